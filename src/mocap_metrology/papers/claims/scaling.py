"""Claims of S 4.2, 4.3 and 4.5 on how noise falls with the number of cameras."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from mocap_metrology.noise.cameras.scaling import fit_scaling
from mocap_metrology.noise.model.components import PowerLaw
from mocap_metrology.noise.twins.published import FRAME_RATE_HZ, SERIES
from mocap_metrology.papers.claims.decide import (
    DOES_NOT,
    HOLDS,
    UNKNOWN,
    Answer,
    Missing,
    Quantity,
    Text,
    at_least,
    decides,
    median_error,
    orders,
    share,
    within,
)
from mocap_metrology.papers.claims.study import COORDINATES, FRAME_S, TYPES, Study, cases

RANGES_S: dict[str, Sequence[float] | np.ndarray] = {
    "up to 0.1 s": (FRAME_S, 0.02, 0.05, 0.1),
    "1 to 100 s": np.geomspace(1, 100, 9),
}
NEAR = 0.15  # of an exponent of a standard deviation: "roughly"
WIDE = 0.25  # two standard errors: half way from Eq. 3 to no law at all, and to its square
LEAST_H = 1e-12  # of a coefficient whose power law is fitted
Numbers = Sequence[float]


def _exponent(n: Numbers, v: Numbers) -> tuple[float, float]:
    """b of v = a n^-b and its standard error; S Eq. 3: 1/2 of a deviation, so 1 of a variance."""
    fit = fit_scaling(np.asarray(n), np.asarray(v))
    if fit is None:
        raise Missing("fewer than two numbers of cameras")
    return -fit.exponent, fit.exponent_error


def _are_half(n: int, *laws: tuple[float, float]) -> str:
    """Whether every exponent (b, standard error) of n levels is 1/2: it is not if Student's 95 %
    interval excludes 1/2; it is only if the error is small enough to decide."""
    from scipy.special import stdtrit

    t = float(stdtrit(n - 2, 0.975))
    if any(abs(b - 0.5) > max(t * error, NEAR) for b, error in laws):
        return DOES_NOT
    return HOLDS if all(2 * error <= WIDE for _, error in laws) else UNKNOWN


@decides("S-4.2-law-{0}")
def _standard_error(study: Study, kind: str) -> Answer:
    """ADEV at one frame against n, geometric mean over the seven series."""
    ns = TYPES[kind]
    levels = [
        np.exp(np.mean([np.log(study.adev((kind, n), s, (FRAME_S,))[0]) for s in SERIES]))
        for n in ns
    ]
    b, error = _exponent(ns, levels)
    return f"exponent {b:.2f} ± {error:.2f}", _are_half(len(ns), (b, error))


@decides("S-4.2-sigma-{0}")
def _sigma(study: Study, kind: str) -> Answer:
    """Standard deviations of whole recordings, which S's Figure 11a shows."""
    rows = [study.gaussian((kind, n)) for n in TYPES[kind]]
    laws = [_exponent(TYPES[kind], [r[f"sigma_{k}_mm"] for r in rows]) for k in (1, 2)]
    text = ", ".join(f"x{k}: {b:.2f} ± {error:.2f}" for k, (b, error) in enumerate(laws, 1))
    return text, _are_half(len(rows), *laws)


@decides("S-4.2-covariance")
def _covariance(study: Study, most: float) -> Answer:
    flat, texts = [], []
    for kind in TYPES:
        ns = TYPES[kind][2:]
        rows = [study.gaussian((kind, n)) for n in ns]
        slope = np.polyfit(np.log(ns), [r["sigma_12_mm2"] for r in rows], 1)[0]
        change = slope * np.log(ns[-1] / ns[0])
        product = float(np.mean([r["sigma_1_mm"] * r["sigma_2_mm"] for r in rows]))
        flat.append(abs(change) < most * product)
        texts.append(f"{kind}: {change:+.2g} of {product:.2g} mm^2")
    return "; ".join(texts), *flat


@decides("S-4.3-gradual")
def _gradual(study: Study, least: float) -> Answer:
    """Whether ADEV falls at each addition of cameras, for all types and series."""
    texts, words = [], []
    for name, tau_s in (("one frame", FRAME_S), ("1 s", 1.0)):
        falls = []
        for kind, ns in TYPES.items():
            for series in SERIES:
                levels = [study.adev((kind, n), series, (tau_s,))[0] for n in ns]
                falls += [bool(b < a) for a, b in pairwise(levels)]
        texts.append(f"{name}: {share(falls)}")
        words.append(at_least(falls, least))
    return "; ".join(texts), *words


@decides("S-4.3-drop-{0}")
def _fall_beyond_scaling(study: Study, kind: str, n_drop: int, most: float) -> Answer:
    """Fall of ADEV at each addition beyond that of Eq. 3, geometric mean over tau and series; one
    range of tau is enough."""
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
        words.append(within(float(beyond[at]), error, -100.0, most))
    word = HOLDS if HOLDS in words else UNKNOWN if UNKNOWN in words else DOES_NOT
    return "; ".join(texts), word


def _of_types(study: Study, name: str, series: Sequence[str]) -> list[tuple[str, Numbers, Numbers]]:
    """(type, cameras, values of a coefficient) by type and series; 0 where it is absent."""
    return [
        (kind, ns, [study.printed((kind, n), s).get(name, 0.0) for n in ns])
        for kind, ns in TYPES.items()
        for s in series
    ]


def _exponent_above(ns: Numbers, values: Numbers, least: float) -> float | None:
    """Exponent through the values above `least`, None of fewer than four."""
    known = [(n, v) for n, v in zip(ns, values, strict=True) if v > least]
    return _exponent(*zip(*known, strict=True))[0] if len(known) >= 4 else None


@decides("S-4.5-white-law", "S-4.5-walk-law")
def _coefficient_law(study: Study, name: str, low: float, high: float) -> Answer:
    """h against n by type: median exponent over the coordinates and L, where h is present."""
    laws: dict[str, list[float]] = {}
    for kind, ns, values in _of_types(study, name, SERIES):
        if (exponent := _exponent_above(ns, values, LEAST_H)) is not None:
            laws.setdefault(kind, []).append(exponent)
    if not laws:
        raise Missing("not enough coefficients above zero")
    texts, words = [], []
    for kind, exponents in laws.items():
        first, middle, last = np.quantile(exponents, [0.16, 0.5, 0.84])
        error = median_error(exponents)
        texts.append(f"{kind}: {middle:.2f} ± {error:.2f} ({first:.1f} to {last:.1f})")
        words.append(within(float(middle), error, low, high))
    return f"exponent of {name}: " + "; ".join(texts), *words


@decides("S-4.5-general")
def _falls_but_violet(study: Study, limit: float) -> Answer:
    """Rank correlation of every h with n, by type and series."""
    from scipy.stats import spearmanr

    texts, words = [], []
    for name in ("h_-2", "h_-1", "h_0", "h_1", "h_2"):
        ranks = [
            spearmanr(ns, values).statistic
            for _, ns, values in _of_types(study, name, SERIES)
            if len(set(values)) > 2
        ]
        middle, error = (float(np.median(ranks)) if ranks else np.nan), median_error(ranks)
        texts.append(f"{name} {middle:+.2f} ± {error:.2f}")
        words.append(within(middle, error, *((limit, 1.0) if name == "h_2" else (-1.5, limit))))
    return "median rank correlation with n: " + ", ".join(texts), *words


@decides("S-4.5-order-white", "S-4.5-order-walk")
def _order(study: Study, exponent: float, name: str, most: float = math.inf) -> Answer:
    """Orders of magnitude of a coefficient, and whether it changes by a factor of `most` at most.
    What ended at a limit of the search is no estimate; if that applies to most, the median is
    unknown."""
    table = _of_types(study, name, COORDINATES)
    values = [v for _, _, of in table for v in of]
    ended = sum(name in study.ended(*case) for case in cases())
    if ended > len(values) / 2:
        return (f"{name}: {ended} of {len(values)} at the limit of the search",), UNKNOWN
    sizes = orders(values, name)
    answers = [
        sizes.near(exponent, 1),
        sizes.between(exponent - 2, exponent + 2) and sizes.zeros <= 0.05,
    ]
    if math.isinf(most):
        return sizes.text, *answers
    # Median over the series, from fewest to most cameras by a law through the values above zero
    decades = [
        abs(b) * math.log10(ns[-1] / ns[0])
        for _, ns, values in table
        if (b := _exponent_above(ns, values, 0.0)) is not None
    ]
    factor = 10 ** (float(np.median(decades)) if decades else np.nan)
    end = ", changes by a factor of ", Quantity(factor, 2), " from fewest to most cameras"
    return (*sizes.text, *end), *answers, factor <= most


@decides("S-4.5-order-flicker-blue")
def _constant(study: Study, exponent: float, most: float, first: str, second: str) -> Answer:
    one, other = (_order(study, exponent, name, most) for name in (first, second))
    text: Text = (*one[0], "; ", *other[0])
    return text, *one[1:], *other[1:]


@decides("S-4.5-violet")
def _violet(study: Study, percent: float) -> Answer:
    """h_2, and its largest share of the Allan variance at one frame, 3 f_h h_2 / (2 pi tau)^2."""
    values = [study.printed(key, series).get("h_2", 0.0) for key, series in cases()]
    shares = [
        PowerLaw(2, h_2).avar(np.ones(1), FRAME_RATE_HZ, "continuous")[0]
        / study.adev(key, series, (FRAME_S,))[0] ** 2
        for h_2, (key, series) in zip(values, cases(), strict=True)
    ]
    if not any(v > 0 for v in values):
        return "none above zero", True
    end = f"; at most {100 * max(shares):.1f} % of AVAR at one frame"
    return (*orders(values, "h_2").text, end), max(shares) < percent / 100
