"""Claims of S 4.2, 4.3 and 4.5 on how noise falls with the number of cameras."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import pairwise

import numpy as np

from mocap_metrology.noise.cameras.scaling import fit_scaling
from mocap_metrology.noise.twins.published import SERIES
from mocap_metrology.present.claims.claim import (
    COORDINATES,
    DOES_NOT,
    HOLDS,
    TYPES,
    UNKNOWN,
    Claim,
    Finding,
    Missing,
    Study,
    by_count,
    decided,
    median_error,
    orders,
    share,
    together,
    unknown,
    whole,
    within,
)

FRAME_S = (1 / 120,)
RANGES_S: dict[str, Sequence[float] | np.ndarray] = {
    "up to 0.1 s": (1 / 120, 0.02, 0.05, 0.1),
    "1 to 100 s": np.geomspace(1, 100, 9),
}
DROP = -10.0  # %
NEAR = 0.15  # of an exponent of a standard deviation: "roughly"
WIDE = 0.25  # two standard errors: half way from Eq. 3 to no law at all, and to its square


def _exponent(n: Sequence[float], v: Sequence[float]) -> tuple[float, float]:
    """b of v = a n^-b and its standard error; S Eq. 3: 1/2 of a deviation, so 1 of a variance."""
    fit = fit_scaling(np.asarray(n), np.asarray(v))
    if fit is None:
        raise Missing(*n)
    return -fit.exponent, fit.exponent_error


def _law_of_adev(study: Study, kind: str) -> tuple[float, float]:
    """ADEV at one frame against n, geometric mean over the seven series."""
    levels = [
        np.exp(np.mean([np.log(study.adev((kind, n), s, FRAME_S)[0]) for s in SERIES]))
        for n in TYPES[kind]
    ]
    return _exponent(TYPES[kind], levels)


def _standard_error(kind: str, study: Study) -> Finding:
    b, error = _law_of_adev(study, kind)
    return Finding(f"exponent {b:.2f} ± {error:.2f}", _half(len(TYPES[kind]), (b, error)))


def _half(n: int, *laws: tuple[float, float]) -> str:
    """Whether every exponent (b, standard error) of n levels is 1/2: not so where Student's 95 %
    interval leaves 1/2 out, and so only where the error is small enough to tell."""
    from scipy.special import stdtrit

    t = float(stdtrit(n - 2, 0.975))
    if any(abs(b - 0.5) > max(t * error, NEAR) for b, error in laws):
        return DOES_NOT
    return HOLDS if all(2 * error <= WIDE for _, error in laws) else UNKNOWN


def _sigma(kind: str, study: Study) -> Finding:
    """Whole-recording standard deviations, which S's Figure 11a shows."""
    try:
        rows = [study.gaussian((kind, n)) for n in TYPES[kind]]
    except KeyError:
        return unknown("Table 4 has the largest sets only; Figure 11 has no numbers", there=False)
    laws = [_exponent(TYPES[kind], [r[f"sigma_{k}_mm"] for r in rows]) for k in (1, 2)]
    text = ", ".join(f"x{k}: {b:.2f} ± {error:.2f}" for k, (b, error) in enumerate(laws, 1))
    return Finding(text, _half(len(rows), *laws))


def _covariance(study: Study) -> Finding:
    try:
        found = {
            kind: [study.gaussian((kind, n))["sigma_12_mm2"] for n in TYPES[kind][2:]]
            for kind in TYPES
        }
    except KeyError:
        return unknown(
            "Table 4 has the largest sets only; Figure 11b has no numbers",
            there=False,
        )
    flat, texts = [], []
    for kind, values in found.items():
        ns = TYPES[kind][2:]
        scale = [study.gaussian((kind, n)) for n in ns]
        drop = np.polyfit(np.log(ns), values, 1)[0] * np.log(ns[-1] / ns[0])
        spread = float(np.mean([r["sigma_1_mm"] * r["sigma_2_mm"] for r in scale]))
        flat.append(abs(drop) < 0.25 * spread)
        texts.append(f"{kind}: {drop:+.2g} of {spread:.2g} mm^2")
    return decided("; ".join(texts), all(flat))


def _steps(study: Study, tau_s: float) -> list[bool]:
    """Whether ADEV falls at each addition of cameras, for all types and series."""
    falls = []
    for kind, ns in TYPES.items():
        for series in SERIES:
            levels = [study.adev((kind, n), series, (tau_s,))[0] for n in ns]
            falls += [b < a for a, b in pairwise(levels)]
    return falls


def _gradual(study: Study) -> Finding:
    frame, second = _steps(study, FRAME_S[0]), _steps(study, 1.0)
    words = [by_count("", steps, 0.75).word for steps in (frame, second)]
    return Finding(f"one frame: {share(frame)}; 1 s: {share(second)}", together(words))


def _drop(kind: str, n_drop: int, study: Study) -> Finding:
    """Fall of ADEV at each addition beyond that of Eq. 3, geometric mean over tau and series."""
    ns = np.array(TYPES[kind])
    texts, words = [], []
    at = list(ns).index(n_drop) - 1
    for name, taus in RANGES_S.items():
        level = np.array(
            [[np.mean(np.log(study.adev((kind, n), s, taus))) for s in SERIES] for n in ns]
        )
        steps = np.diff(level, axis=0) + np.diff(np.log(ns))[:, None] / 2
        beyond = 100 * np.expm1(steps.mean(axis=1))
        error = 200 * float(steps[at].std(ddof=1)) / np.sqrt(len(SERIES))
        steepest = f"steepest at {ns[1:][beyond.argmin()]} ({beyond.min():+.0f} %)"
        texts.append(f"{name} {beyond[at]:+.0f} ± {error:.0f} % at {n_drop}, {steepest}")
        words.append(within(float(beyond[at]), error, -100.0, DROP))
    word = HOLDS if HOLDS in words else UNKNOWN if UNKNOWN in words else DOES_NOT
    return Finding("; ".join(texts), word)


def _coefficient_law(name: str, study: Study) -> Finding:
    """h against n per type: median exponent over the coordinates and L, where h is there."""
    texts, good = [], []
    for kind, ns in TYPES.items():
        slopes = []
        for series in SERIES:
            values = [study.printed((kind, n), series).get(name, 0.0) for n in ns]
            known = [(n, v) for n, v in zip(ns, values, strict=True) if v > 1e-12]
            if len(known) >= 4:
                slopes.append(_exponent(*zip(*known, strict=True))[0])
        if slopes:
            low, middle, high = np.quantile(slopes, [0.16, 0.5, 0.84])
            error = median_error(slopes)
            texts.append(f"{kind}: {middle:.2f} ± {error:.2f} ({low:.1f} to {high:.1f})")
            good.append(within(float(middle), error, 0.5, 2.0))
    if not good:
        return unknown("not enough coefficients above zero")
    return Finding(f"exponent of {name}: " + "; ".join(texts), together(good))


def _falls_but_violet(study: Study) -> Finding:
    """Rank correlation of every h with n, by type and series."""
    from scipy.stats import spearmanr

    texts, words = [], []
    for name in ("h_-2", "h_-1", "h_0", "h_1", "h_2"):
        found = []
        for kind, ns in TYPES.items():
            for series in SERIES:
                values = [study.printed((kind, n), series).get(name, 0.0) for n in ns]
                if len(set(values)) > 2:
                    found.append(spearmanr(ns, values).statistic)
        middle, error = (float(np.median(found)) if found else np.nan), median_error(found)
        texts.append(f"{name} {middle:+.2f} ± {error:.2f}")
        words.append(within(middle, error, *((-0.3, 1.0) if name == "h_2" else (-1.5, -0.3))))
    return Finding("median rank correlation with n: " + ", ".join(texts), together(words))


def _order(
    names: tuple[str, ...], exponent: float, study: Study, constant: bool = False
) -> Finding:
    """Median within a factor of ten of 10^exponent, and nine in ten within a hundred, counting
    those of zero as outside; `constant`: and over the cameras within a factor of ten. What ended at
    a limit of the search is no number; where that is most of them, the median is unknown."""
    texts, good = [], []
    for name in names:
        table = [
            (ns, [study.printed((kind, n), series).get(name, 0.0) for n in ns])
            for kind, ns in TYPES.items()
            for series in COORDINATES
        ]
        values = [v for _, of in table for v in of]
        ended = sum(
            name in study.ended((kind, n), series)
            for kind, ns in TYPES.items()
            for n in ns
            for series in COORDINATES
        )
        if ended > len(values) / 2:
            texts.append(f"{name}: {ended} of {len(values)} at the limit of the search")
            good.append(UNKNOWN)
            continue
        if not any(v > 0 for v in values):
            return unknown(f"no {name} above zero")
        low, middle, high = orders(values)
        none = sum(not v > 0 for v in values)
        text = f"{name}: 10^{middle:.1f} (10^{low:.0f} to 10^{high:.1f}){_zeros(none, values)}"
        error = median_error(np.log10([v for v in values if v > 0]))
        good.append(within(middle, error, exponent - 1, exponent + 1))
        rest = exponent - 2 <= low and high <= exponent + 2 and none <= 0.05 * len(values)
        good.append(HOLDS if rest else DOES_NOT)
        if constant:
            change = _change(table)
            text += f", by 10^{change:.1f} from fewest to most cameras"
            good.append(HOLDS if change <= 1 else DOES_NOT)
        texts.append(text)
    return Finding("; ".join(texts), together(good))


def _zeros(none: int, values: Sequence[float]) -> str:
    """What logarithms leave out."""
    return f", {none} of {len(values)} zero" if none else ""


def _change(table: Sequence[tuple[Sequence[int], Sequence[float]]]) -> float:
    """Median over the series of |log10| of the factor between fewest and most cameras, by a power
    law through what is above zero in four subsets or more; NaN without such a series."""
    found = []
    for ns, values in table:
        known = [(n, v) for n, v in zip(ns, values, strict=True) if v > 0]
        if len(known) >= 4:
            b = _exponent(*zip(*known, strict=True))[0]
            found.append(abs(b) * np.log10(ns[-1] / ns[0]))
    return float(np.median(found)) if found else np.nan


def _violet(study: Study) -> Finding:
    shares, values = [], []
    for kind, ns in TYPES.items():
        for n in ns:
            for series in COORDINATES:
                h_2 = study.printed((kind, n), series).get("h_2", 0.0)
                values.append(h_2)
                level = study.adev((kind, n), series, FRAME_S)[0] ** 2
                shares.append(3 * 60 * h_2 / (4 * np.pi**2 * FRAME_S[0] ** 2) / level)
    if not any(v > 0 for v in values):
        return decided("none above zero", True)
    low, middle, high = orders(values)
    text = (
        f"10^{middle:.0f} (10^{low:.0f} to 10^{high:.1f})"
        f"{_zeros(sum(not v > 0 for v in values), values)}; "
        f"at most {100 * max(shares):.1f} % of AVAR at one frame"
    )
    return decided(text, max(shares) < 0.02)


def _means(study: Study) -> Finding:
    lengths = [study.gaussian(key)["mu_L_mm"] for key in (*map(whole, TYPES), ("All", 30))]
    spread = max(lengths) - min(lengths)
    return decided(f"mu_L spans {spread:.2f} mm", 0.03 <= spread <= 0.5)


LAW = "exponent b of ADEV(one frame) = a n^-b, geometric mean of the seven series"
ROUGHLY = (
    f"1/2 within {NEAR} or Student's 95 % interval; undecided if it is and two standard errors "
    f"exceed {WIDE}"
)
CLAIMS: Sequence[Claim[Study]] = (
    *(
        Claim(
            f"S-4.2-law-{kind}",
            "4.2",
            f"{kind}: noise falls with the number of cameras as the standard error (Eq. 3)",
            LAW,
            ROUGHLY,
            partial(_standard_error, kind),
        )
        for kind in TYPES
    ),
    *(
        Claim(
            f"S-4.2-sigma-{kind}",
            "4.2",
            f"{kind}: variances of the whole recording adhere to Eq. 3 (Figure 11a)",
            "exponent b of sigma = a n^-b of x1 and x2",
            ROUGHLY,
            partial(_sigma, kind),
            "nine-hour standard deviations are mostly random walk, with one history per type",
            by_chance=True,
        )
        for kind in TYPES
    ),
    Claim(
        "S-4.2-covariance",
        "4.2",
        "covariance of x1 and x2 is constant in the number of cameras but for the lowest",
        "change of sigma_12 from 4 to most cameras (line in ln n), beside mean sigma_1 sigma_2",
        "below a quarter of sigma_1 sigma_2 for every type",
        _covariance,
        "nine-hour covariances are mostly random walk, with one history per type",
        by_chance=True,
    ),
    Claim(
        "S-4.2-means",
        "4.2",
        "camera sets report means that differ by tenths of a millimetre (Figure 10)",
        "range of mu_L over T40, Bonita, Vantage and all",
        "0.03 to 0.5 mm",
        _means,
        "twins start at the means of Table 4",
    ),
    Claim(
        "S-4.3-gradual",
        "4.3",
        "ADEV gradually decreases with the number of cameras",
        "share of additions, over types and series, at which ADEV falls, at one frame and 1 s",
        "three in four at both",
        _gradual,
    ),
    *(
        Claim(
            f"S-4.3-drop-{kind}",
            "4.3",
            f"{kind}: a drop at {n} cameras",
            "change of ADEV at it beyond Eq. 3, short and long tau, mean over the series",
            f"below {DROP:.0f} % in either range of tau",
            partial(_drop, kind, n),
        )
        for kind, n in (("T40", 3), ("Bonita", 5), ("Vantage", 4))
    ),
    Claim(
        "S-4.5-white-law",
        "4.5",
        "white noise diminishes with n following roughly Eq. 3",
        "exponent b of h_0 = a n^-b, median over the series (16 to 84 %)",
        "between 1/2 and 2 for every type (Eq. 3: 1)",
        partial(_coefficient_law, "h_0"),
    ),
    Claim(
        "S-4.5-walk-law",
        "4.5",
        "random walk diminishes with n following roughly Eq. 3",
        "exponent b of h_-2 = a n^-b, median over the series (16 to 84 %)",
        "between 1/2 and 2 for every type (Eq. 3: 1)",
        partial(_coefficient_law, "h_-2"),
    ),
    Claim(
        "S-4.5-order-white",
        "4.5, 5",
        "white noise: h of the order of 1e-5",
        "median and 5 to 95 % of h_0 over types, subsets and coordinates",
        "median within a factor of 10; all others, including zeros, within 100",
        partial(_order, ("h_0",), -5),
    ),
    Claim(
        "S-4.5-order-walk",
        "4.5, 5",
        "random walk: h of the order of 1e-5",
        "the same of h_-2",
        "median within a factor of 10; all others, including zeros, within 100",
        partial(_order, ("h_-2",), -5),
    ),
    Claim(
        "S-4.5-order-flicker-blue",
        "4.5, 5",
        "flicker and blue noise are relatively constant, of the order of 1e-10",
        "the same of h_-1 and h_1, and their change with the cameras (power law, median series)",
        "medians within a factor of 10; all others, including zeros, within 100; at most a "
        "factor of 10 over the cameras",
        partial(_order, ("h_-1", "h_1"), -10, constant=True),
        "the appendix contradicts the text",
    ),
    Claim(
        "S-4.5-violet",
        "4.5, 5",
        "violet noise is negligible (h from 1e-20 down to 1e-300)",
        "median and 5 to 95 % of h_2, and its greatest share of AVAR at one frame",
        "share below 2 %",
        _violet,
        (
            "printed values reach 2e-8, far above 1e-20; AVAR hardly distinguishes violet from "
            "blue noise"
        ),
    ),
    Claim(
        "S-4.5-general",
        "4.5",
        "every h falls with more cameras to some extent, but violet, which is random",
        "Spearman's rank correlation of h with n, median over types and series",
        "below -0.3 for all but h_2, and not so for h_2",
        _falls_but_violet,
    ),
)
