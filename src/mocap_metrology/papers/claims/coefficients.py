"""Claims of S 4.6 and 5 on correlated and periodic noise, and on what contributes most."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mocap_metrology.noise.cameras.scaling import fit_scaling
from mocap_metrology.noise.model.components import Sinusoid
from mocap_metrology.noise.twins.published import SERIES
from mocap_metrology.papers.claims import study as numbers
from mocap_metrology.papers.claims.decide import (
    DOES_NOT,
    HOLDS,
    UNKNOWN,
    Answer,
    Missing,
    Quantity,
    decides,
    orders,
    share,
    within,
)
from mocap_metrology.papers.claims.study import FRAME_S, TYPES, Key, Study

LINE_HZ = (13.0, 16.0)  # S's "15 Hz"
CLASSES = {  # log10 of the limits of T_c in s
    "0.01 to 1 s": (-2, 0),
    "1 to 10 s": (0, 1),
    "10 to 100 s": (1, 2),
    "100 to 1000 s": (2, 3),
}


def _terms(study: Study) -> np.ndarray:
    """(q_c, T_c) of all correlated components, (k, 2)."""
    every = [term for case in numbers.cases(SERIES) for term in numbers.active_terms(study, *case)]
    return np.array(every)


@decides("S-4.6-independent")
def _independent_of_n(study: Study, mostly: float) -> Answer:
    """Power law in n of each printed component's T_c and q_c, by type and series: independent of n
    or not. The claim is decided if the components that are not precise enough cannot change it."""
    words: dict[str, list[str]] = {"T_c": [], "q_c": []}
    for kind, ns in TYPES.items():
        for series in SERIES:
            rows = [study.printed((kind, n), series) for n in ns]
            for k in (1, 2, 3):
                terms = [(n, row.get(f"q_c{k}", 0), row.get(f"T_c{k}", 0))
                         for n, row in zip(ns, rows, strict=True)]  # fmt: skip
                there = [(n, q, t) for n, q, t in terms if q**2 * t / 2 >= numbers.LEAST_VARIANCE]
                if len(there) < 5:
                    continue
                n, q, t = zip(*there, strict=True)
                for name, values in (("q_c", q), ("T_c", t)):
                    if len(set(values)) > 2:
                        words[name].append(independent(n, values))
    if not words["T_c"] or not words["q_c"]:
        raise Missing("no component in at least five subsets of a series")
    texts, answers = [], []
    for name, of in words.items():
        yes, no = of.count(HOLDS), of.count(DOES_NOT)
        texts.append(f"{name}: independent of n {yes}, not {no}, undecided {of.count(UNKNOWN)}")
        rest = HOLDS if yes >= mostly * len(of) else UNKNOWN
        answers.append(DOES_NOT if no > (1 - mostly) * len(of) else rest)
    return "; ".join(texts), *answers


def independent(n: Sequence[int], values: Sequence[float]) -> str:
    """Whether values (k,) are independent of n (k,): they are if the 95 % interval (Student's,
    k - 2 degrees of freedom) of the exponent b of n^b contains 0 and excludes -1/2, that of Eq. 3;
    they are not if it excludes 0; otherwise the interval is too wide."""
    from scipy.special import stdtrit

    law = fit_scaling(np.asarray(n), np.asarray(values))
    if law is None or not np.isfinite(law.exponent_error):
        return UNKNOWN
    reach = stdtrit(len(n) - 2, 0.975) * law.exponent_error
    if abs(law.exponent) > reach:
        return DOES_NOT
    return HOLDS if law.exponent - reach > -0.5 else UNKNOWN


@decides("S-4.6-longer-lower")
def _longer_is_lower(study: Study, p_value: float) -> Answer:
    from scipy.stats import linregress

    q, t = _terms(study).T
    fit = linregress(np.log10(t), np.log10(q))
    text = f"q_c ~ T_c^({fit.slope:.2f} ± {fit.stderr:.2f}), {len(q)} components"
    return text, fit.slope < 0 and fit.pvalue < p_value


@decides("S-4.6-classes")
def _classes(study: Study, factor: float) -> Answer:
    """Components per decade of T_c in the three classes and in the gap between them."""
    t = np.log10(_terms(study)[:, 1])
    density = {
        name: np.sum((t >= low) & (t < high + (high == 3) * 1e-9)) / (high - low)
        for name, (low, high) in CLASSES.items()
    }
    gap, beyond = density.pop("10 to 100 s"), int(np.sum(t > 3 + 1e-9))
    text = ", ".join(f"{name}: {value:.0f}" for name, value in density.items())
    error = 2 * factor * np.sqrt(gap)  # of so many times a count in a decade
    words = [
        within(value - factor * gap, error + 2 * np.sqrt(value), 0.0, np.inf)
        for value in density.values()
    ]
    return f"per decade {text}; gap 10 to 100 s: {gap:.0f}; above 1000 s: {beyond}", *words


def _near_fifteen(study: Study, key: Key, series: str) -> list[float]:
    return [a for f, a in study.lines(key, series) if LINE_HZ[0] <= f <= LINE_HZ[1]]


def _amplitudes(study: Study, kind: str, series: Sequence[str] = SERIES) -> list[float]:
    return [a for n in TYPES[kind] for s in series for a in _near_fifteen(study, (kind, n), s)]


@decides("S-4.6-line-{0}")
def _line_present(study: Study, kind: str) -> Answer:
    keys = [(kind, n) for n in TYPES[kind]]
    if kind != "T40" and not any(study.lines(key, s) for key in keys for s in SERIES):
        raise Missing(f"no periodic term of {kind} is printed, and its twins have none")
    there = [[bool(_near_fifteen(study, key, s)) for s in SERIES] for key in keys]
    rows, total = [any(row) for row in there], len(keys) * len(SERIES)
    text = f"13 to 16 Hz in {share(rows)} reconstructions, "
    return f"{text}{sum(map(sum, there))} of {total} series", all(rows)


@decides("S-4.6-vertical")
def _vertical(study: Study) -> Answer:
    sizes = {axis: _amplitudes(study, "T40", (f"{axis}1", f"{axis}2")) for axis in "xyz"}
    text: list[str | Quantity] = []
    for axis, values in sizes.items():
        text.append(f"{', ' if text else ''}{axis}: {len(values)} series")
        text += [", ", Quantity(float(np.median(values)), 2, "mm")] if values else []
    others = [np.median(sizes[axis]) for axis in "xy" if sizes[axis]]
    good = bool(sizes["z"]) and len(sizes["z"]) > max(len(sizes["x"]), len(sizes["y"]))
    return tuple(text), good and all(np.median(sizes["z"]) > other for other in others)


@decides("S-5-amplitude")
def _amplitude(study: Study, expected_mm: float) -> Answer:
    amplitudes = [a for kind in TYPES for a in _amplitudes(study, kind)]
    if not amplitudes:
        raise Missing("no periodic term between 13 and 16 Hz")
    sizes = orders(amplitudes, "A_s")
    return (*sizes.text, f", {len(amplitudes)} series"), sizes.near(np.log10(expected_mm), 0.5)


@decides("S-4.6-negligible")
def _negligible(study: Study, visible: float) -> Answer:
    """Share of AVAR that the line contributes at its own first maximum, tau = 0.371 / f_0, in the
    series of the two types for which S reports it."""
    chosen = [case for case in numbers.cases(SERIES) if case[0][0] in ("T40", "Vantage")]
    shares = [
        numbers.avar(Sinusoid(a, f_0), 0.371 / f_0)
        / study.adev(key, series, (0.371 / f_0,))[0] ** 2
        for key, series in chosen
        for f_0, a in study.lines(key, series)
        if LINE_HZ[0] <= f_0 <= LINE_HZ[1]
    ]
    if not shares:
        raise Missing("no periodic term between 13 and 16 Hz")
    seen = sum(s >= visible for s in shares)
    text = f"a tenth or more in {seen} of {len(chosen)} series, {100 * max(shares):.0f} % at most"
    return text, seen < len(chosen) / 2


@decides("S-5-main")
def _contributions(study: Study, most: float, least: float) -> Answer:
    """Medians over subsets and coordinates of the share of AVAR that white noise and random walk
    contribute, at one frame and at 1000 s."""
    groups = {"white noise and random walk": (0, -2), "flicker and blue noise": (-1, 1)}
    models = [numbers.model_of(study, *case) for case in numbers.cases()]
    median = {
        name: [
            100 * float(np.median([numbers.share_of_avar(m, tau, alphas) for m in models]))
            for tau in (FRAME_S, 1000.0)
        ]
        for name, alphas in groups.items()
    }
    text = "; ".join(
        f"{name}: {short:.0f} % at one frame, {long:.0f} % at 1000 s"
        for name, (short, long) in median.items()
    )
    main, small = median.values()
    return text, min(main) > most and max(small) < least


@decides("S-5-long-term")
def _long_term(study: Study, low: float, high: float) -> Answer:
    """Correlated components with T_c of 100 to 1000 s, and their q_c."""
    q = [q for q, t in _terms(study) if 100 <= t <= 1000]
    if not q:
        raise Missing("no component with T_c of 100 to 1000 s")
    sizes = orders(q, "q_c")
    return (f"{len(q)} components, ", *sizes.text), sizes.between(np.log10(low), np.log10(high))


@decides("S-5-quality")
def _reverse_of_quality(study: Study) -> Answer:
    """Number of series with the line by camera type, against the noise of one frame."""
    counts = {kind: n for kind in TYPES if (n := len(_amplitudes(study, kind)))}
    if len(counts) < 2:
        raise Missing("only T40 has periodic terms near 15 Hz")
    noise = {kind: study.adev(numbers.WHOLE[kind], "L", (FRAME_S,))[0] for kind in counts}
    order = sorted(counts, key=noise.__getitem__, reverse=True)
    text = ", ".join(f"{kind}: {counts[kind]} series" for kind in order)
    falling = sorted(counts.values(), reverse=True)
    return f"noisiest first, {text}", [counts[kind] for kind in order] == falling
