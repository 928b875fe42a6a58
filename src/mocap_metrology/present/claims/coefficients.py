"""Claims of S 4.6 and 5 on correlated and periodic noise, and on what contributes most."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from mocap_metrology.noise.cameras.scaling import fit_scaling
from mocap_metrology.noise.model.components import Sinusoid
from mocap_metrology.noise.twins.published import FRAME_RATE_HZ, SERIES
from mocap_metrology.present.claims.claim import (
    COORDINATES,
    DOES_NOT,
    HOLDS,
    TYPES,
    UNKNOWN,
    Claim,
    Finding,
    Study,
    active_terms,
    decided,
    median_error,
    model_of,
    orders,
    share,
    subsets,
    together,
    unknown,
    whole,
    within,
)

LINE_HZ = (13.0, 16.0)  # S's "15 Hz"
MOSTLY = 0.8
VISIBLE = 0.1  # share of AVAR from which a bump is seen
CLASSES = {
    "0.01 to 1 s": (-2, 0),
    "1 to 10 s": (0, 1),
    "10 to 100 s": (1, 2),
    "100 to 1000 s": (2, 3),
}


def _terms(study: Study) -> list[tuple[float, float]]:
    return [term for key in subsets() for s in SERIES for term in active_terms(study, key, s)]


def _independent_of_n(study: Study) -> Finding:
    """Power law in n of each printed component's T_c and q_c, by type and series: whether it is
    independent of n or follows it. Where some are not precise enough to tell, the claim is decided
    if it would be the same whatever those are."""
    found: dict[str, list[str]] = {"T_c": [], "q_c": []}
    for kind, ns in TYPES.items():
        for series in SERIES:
            rows = [study.printed((kind, n), series) for n in ns]
            for k in (1, 2, 3):
                there = [
                    (n, row[f"q_c{k}"], row[f"T_c{k}"])
                    for n, row in zip(ns, rows, strict=True)
                    if row.get(f"q_c{k}", 0) ** 2 * row.get(f"T_c{k}", 0) / 2 >= 1e-9
                ]
                if len(there) < 5:
                    continue
                n, q, t = zip(*there, strict=True)
                for name, values in (("q_c", q), ("T_c", t)):
                    if len(set(values)) > 2:
                        found[name].append(independent(n, values))
    if not found["T_c"] or not found["q_c"]:
        return unknown("no component in at least five subsets of a series")
    counts = {k: [v.count(w) for w in (HOLDS, DOES_NOT, UNKNOWN)] for k, v in found.items()}
    text = "; ".join(
        f"{name}: independent of n {yes}, not {no}, undecided {rest}"
        for name, (yes, no, rest) in counts.items()
    )
    if any(no > (1 - MOSTLY) * (yes + no + rest) for yes, no, rest in counts.values()):
        return decided(text, False)
    if all(yes >= MOSTLY * (yes + no + rest) for yes, no, rest in counts.values()):
        return decided(text, True)
    return Finding(text, UNKNOWN)


def independent(n: Sequence[int], values: Sequence[float]) -> str:
    """Whether values (k,) do not depend on n (k,): holds if the 95 % interval (Student's, k - 2
    degrees of freedom) of the exponent b of n^b contains 0 and leaves out -1/2, that of Eq. 3;
    does not if it leaves out 0; else the interval is too wide to tell."""
    from scipy.special import stdtrit

    law = fit_scaling(np.asarray(n), np.asarray(values))
    if law is None or not np.isfinite(law.exponent_error):
        return UNKNOWN
    reach = stdtrit(len(n) - 2, 0.975) * law.exponent_error
    if abs(law.exponent) > reach:
        return DOES_NOT
    return HOLDS if law.exponent - reach > -0.5 else UNKNOWN


def _longer_is_lower(study: Study) -> Finding:
    from scipy.stats import linregress

    q, t = np.array(_terms(study)).T
    fit = linregress(np.log10(t), np.log10(q))
    text = f"q_c ~ T_c^({fit.slope:.2f} ± {fit.stderr:.2f}), {len(q)} components"
    return decided(text, fit.slope < 0 and fit.pvalue < 0.01)


def _classes(study: Study) -> Finding:
    """Components per decade of T_c in the three classes and in the gap between them."""
    t = np.log10([term[1] for term in _terms(study)])
    density = {
        name: np.sum((t >= low) & (t < high + (high == 3) * 1e-9)) / (high - low)
        for name, (low, high) in CLASSES.items()
    }
    gap = density.pop("10 to 100 s")
    text = ", ".join(f"{name}: {value:.0f}" for name, value in density.items())
    beyond = int(np.sum(t > 3 + 1e-9))
    error = 2 * np.sqrt(4 * gap)  # of twice a count in a decade
    words = [
        within(value - 2 * gap, error + 2 * np.sqrt(value), 0.0, np.inf)
        for value in density.values()
    ]
    said = f"a decade {text}; gap 10 to 100 s: {gap:.0f}; above 1000 s: {beyond}"
    return Finding(said, together(words))


def _near_fifteen(study: Study, key: tuple[str, int], series: str) -> list[float]:
    return [a for f, a in study.lines(key, series) if LINE_HZ[0] <= f <= LINE_HZ[1]]


def _present(kind: str) -> Callable[[Study], Finding]:
    def find(study: Study) -> Finding:
        if kind != "T40" and not any(
            study.lines((kind, n), s) for n in TYPES[kind] for s in SERIES
        ):
            return unknown(f"no periodic term of {kind} is printed, and its twins have none")
        there = [any(_near_fifteen(study, (kind, n), s) for s in SERIES) for n in TYPES[kind]]
        rows = [bool(_near_fifteen(study, (kind, n), s)) for n in TYPES[kind] for s in SERIES]
        text = f"13 to 16 Hz in {share(there)} reconstructions, {sum(rows)} of {len(rows)} series"
        return decided(text, all(there))

    return find


def _vertical(study: Study) -> Finding:
    sizes = {
        axis: [
            a
            for n in TYPES["T40"]
            for k in (1, 2)
            for a in _near_fifteen(study, ("T40", n), f"{axis}{k}")
        ]
        for axis in "xyz"
    }
    text = ", ".join(
        f"{axis}: {len(found)} series" + (f", {1000 * np.median(found):.2g} µm" if found else "")
        for axis, found in sizes.items()
    )
    others = [np.median(sizes[axis]) for axis in "xy" if sizes[axis]]
    good = bool(sizes["z"]) and len(sizes["z"]) > max(len(sizes["x"]), len(sizes["y"]))
    good = good and all(np.median(sizes["z"]) > other for other in others)
    return decided(text, good)


def _amplitude(study: Study) -> Finding:
    found = [a for key in subsets() for series in SERIES for a in _near_fifteen(study, key, series)]
    if not found:
        return unknown("no periodic term between 13 and 16 Hz")
    low, middle, high = orders(found)
    text = f"A_s: 10^{middle:.1f} mm (10^{low:.1f} to 10^{high:.1f}), {len(found)} series"
    return Finding(text, within(middle, median_error(np.log10(found)), -3.5, -2.5))


def _negligible(study: Study) -> Finding:
    """Share of AVAR that the line makes at the first maximum of its own, tau = 0.371 / f_0, in the
    series of both types that S sees it with."""
    chosen = [key for key in subsets() if key[0] in ("T40", "Vantage")]
    shares = []
    for key in chosen:
        for series in SERIES:
            for f_0, a in study.lines(key, series):
                if LINE_HZ[0] <= f_0 <= LINE_HZ[1]:
                    m = np.array([0.371 / f_0 * FRAME_RATE_HZ])
                    own = Sinusoid(a, f_0).avar(m, FRAME_RATE_HZ, "continuous")[0]
                    shares.append(own / study.adev(key, series, m / FRAME_RATE_HZ)[0] ** 2)
    if not shares:
        return unknown("no periodic term between 13 and 16 Hz")
    n = len(chosen) * len(SERIES)
    visible = sum(s >= VISIBLE for s in shares)
    text = f"a tenth or more in {visible} of {n} series, {100 * max(shares):.0f} % at most"
    return decided(text, visible < n / 2)


def _contributions(study: Study) -> Finding:
    """Medians over subsets and coordinates of the share of AVAR that white noise and random walk
    make, at one frame and at 1000 s; in continuous time, as S fits the coefficients."""
    found: dict[tuple[str, float], list[float]] = {}
    groups = {"white and walk": (0, -2), "flicker and blue": (-1, 1)}
    for key in subsets():
        for series in COORDINATES:
            model = model_of(study, key, series)
            for tau in (1 / 120, 1000.0):
                m = np.array([tau * 120])
                total = model.avar(m, 120, "continuous")[0]
                for name, alphas in groups.items():
                    part = sum(
                        c.avar(m, 120, "continuous")[0]
                        for c in model.components
                        if getattr(c, "alpha", None) in alphas
                    )
                    found.setdefault((name, tau), []).append(part / total)
    median = {k: 100 * float(np.median(v)) for k, v in found.items()}
    text = "; ".join(
        f"{name}: {median[name, 1 / 120]:.0f} % at one frame, "
        f"{median[name, 1000.0]:.0f} % at 1000 s"
        for name in groups
    )
    main = all(median["white and walk", tau] > 50 for tau in (1 / 120, 1000.0))
    small = all(median["flicker and blue", tau] < 1 for tau in (1 / 120, 1000.0))
    return decided(text, main and small)


def _long_term(study: Study) -> Finding:
    """Correlated components with T_c of 100 to 1000 s, and their q_c."""
    q = [q for q, t in _terms(study) if 100 <= t <= 1000]
    if not q:
        return unknown("no component with T_c of 100 to 1000 s")
    low, middle, high = orders(q)
    text = f"{len(q)} components, q_c 10^{middle:.1f} (10^{low:.1f} to 10^{high:.1f})"
    return decided(text, low >= -13 and high <= -2.5)


def _reverse_of_quality(study: Study) -> Finding:
    """Number of series with the line by camera type, against the noise of one frame."""
    sizes = {
        kind: [a for n in TYPES[kind] for s in SERIES for a in _near_fifteen(study, (kind, n), s)]
        for kind in TYPES
    }
    known = [kind for kind, found in sizes.items() if found]
    if len(known) < 2:
        return unknown("only T40 has periodic terms near 15 Hz")
    noise = {kind: study.adev(whole(kind), "L", (1 / 120,))[0] for kind in known}
    shares = {kind: len(sizes[kind]) for kind in known}
    order = sorted(known, key=noise.__getitem__, reverse=True)
    text = ", ".join(f"{kind}: {shares[kind]} series" for kind in order)
    counts = [shares[kind] for kind in order]
    return decided(f"noisiest first, {text}", counts == sorted(counts, reverse=True))


CLAIMS: Sequence[Claim[Study]] = (
    Claim(
        "S-4.6-independent",
        "4.6",
        "T_c and q_c of correlated noise are mostly independent of the number of cameras",
        "components, by type and series, whose exponent of n is 0 and not -1/2 (95 % interval)",
        (
            "holds for four in five of both; does not hold if more than one in five of either "
            "depend on n"
        ),
        _independent_of_n,
        "the numbers of components differ between rows",
    ),
    Claim(
        "S-4.6-longer-lower",
        "4.6",
        "the longer the correlation time, the lower the amplitude",
        "exponent of q_c against T_c over all components",
        "below 0, p < 0.01",
        _longer_is_lower,
    ),
    Claim(
        "S-4.6-classes",
        "4.6",
        "three classes of T_c: 0.01 to 1 s, 1 to 10 s, 100 to 1000 s",
        "components a decade in each class and in the gap from 10 to 100 s",
        "each class more than twice the gap",
        _classes,
        "components of variance 1e-9 mm^2 and more",
    ),
    *(
        Claim(
            f"S-4.6-line-{kind}",
            "4.6",
            f"{kind}: a periodic disturbance near 15 Hz in every reconstruction",
            "reconstructions with a sinusoid between 13 and 16 Hz",
            "all",
            _present(kind),
            "the appendix prints periodic terms of T40 alone, and not for x",
        )
        for kind in ("T40", "Vantage")
    ),
    Claim(
        "S-4.6-vertical",
        "4.6",
        "the vertical dimension of T40 is the most sensitive to it",
        "series with it and its median amplitude, by axis",
        "most series and the largest amplitude in z",
        _vertical,
    ),
    Claim(
        "S-4.6-negligible",
        "4.6",
        "it is usually negligibly small, barely observable in most ADEV plots",
        "series of T40 and Vantage in which it makes a tenth of AVAR where it makes most",
        "fewer than half",
        _negligible,
    ),
    Claim(
        "S-5-main",
        "5",
        "random walk and white noise contribute most; flicker and blue orders of magnitude less",
        "median share of AVAR at one frame and at 1000 s",
        "above 50 % and below 1 %",
        _contributions,
        "correlated noise contributes the rest",
    ),
    Claim(
        "S-5-long-term",
        "5",
        "a long-term correlated noise with T_c of 100 to 1000 s and q_c of 1e-13 to 1e-3",
        "components with such a T_c; median and 5 to 95 % of q_c",
        "nine in ten between 1e-13 and 3e-3",
        _long_term,
    ),
    Claim(
        "S-5-amplitude",
        "5",
        "the 15 Hz disturbance has an amplitude of about 1e-3",
        "median and 5 to 95 % of A_s between 13 and 16 Hz",
        "median within a factor of three",
        _amplitude,
    ),
    Claim(
        "S-5-quality",
        "5",
        "the 15 Hz disturbance is visible to the cameras reversely to their overall quality",
        "series with it by camera type, against ADEV of L at one frame",
        "the noisier the type, the more series",
        _reverse_of_quality,
        "section 4.6: T40, the least noisy type, shows it most",
    ),
)
