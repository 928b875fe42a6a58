"""Claims of S 3.5, 4.2, 4.3 and 4.4 on Allan deviations and on the Gaussian model."""

from __future__ import annotations

import numpy as np

from mocap_metrology.noise.twins.published import SERIES
from mocap_metrology.present.claims.claim import Finding, Missing, Rules, at_least, decided, share
from mocap_metrology.present.claims.study import (
    SUBSETS,
    TYPES,
    WHOLE,
    Key,
    Regenerated,
    Study,
    cases,
    model_of,
    share_of_avar,
)

decides = Rules()
SHORT_S = np.geomspace(0.01, 0.1, 7)
ALL_S = np.geomspace(0.01, 1000.0, 26)
SLOPES = (-1.0, -0.5, 0.0, 0.5)
SYSTEMS = (*WHOLE.values(), ("All", 30))  # rows of Table 4


def _taus(study: Study, *keys: Key) -> np.ndarray:
    """Averaging times up to 1000 s that all of these recordings reach; `Missing` without any."""
    taus = ALL_S[min(study.longest_s(key) for key in keys) >= ALL_S]
    if taus.size < 3:
        raise Missing(f"too short: {keys[0][0]} {keys[0][1]}")
    return taus


@decides("S-4.3-distance-short")
def _distance_above(study: Study, least: float) -> Finding:
    above = [
        bool(np.all(study.adev(key, "L", SHORT_S) > study.adev(key, s, SHORT_S)))
        for key, s in cases(("x1", "x2"))
    ]
    return decided(f"{share(above)} curves below that of L", at_least(above, least))


@decides("S-4.3-distance-long")
def _distance_below(study: Study, least: float) -> Finding:
    below = []
    for key in SUBSETS:
        taus = _taus(study, key)
        taus = taus[taus >= 1.0]
        most = np.maximum(study.adev(key, "x1", taus), study.adev(key, "x2", taus))
        below += (study.adev(key, "L", taus) <= 1.1 * most).tolist()
    return decided(share(below), at_least(below, least))


@decides("S-4.3-slopes")
def _slopes(study: Study, near: float) -> Finding:
    """Local slopes over a third of a decade, of every subset and series."""
    found = dict.fromkeys(SLOPES, 0)
    curves = list(cases(SERIES))
    for key, series in curves:
        taus = _taus(study, key)
        level = np.log(study.adev(key, series, taus))
        local = (level[2:] - level[:-2]) / (np.log(taus[1] / taus[0]) * 2)
        for slope in SLOPES:
            found[slope] += bool(np.any(np.abs(local - slope) < near))
    text = ", ".join(f"{slope:+g} in {count}" for slope, count in found.items())
    return decided(f"{text} of {len(curves)} curves", all(found.values()))


@decides("S-4.3-walk")
def _random_walk(study: Study, least: float) -> Finding:
    """Share of h_-2 in AVAR at 1000 s, and its share with T_c of 1000 s and more (same shape)."""
    models = [model_of(study, *case) for case in cases()]
    there = [share_of_avar(m, 1000.0, (-2,)) > 0.1 for m in models]
    alike = [share_of_avar(m, 1000.0, (-2,), 1000.0) > 0.1 for m in models]
    text = f"h_-2 in {share(there)}; including correlated noise of 1000 s and more {share(alike)}"
    return decided(text, at_least(there, least))


@decides("S-4.4-Bonita", "S-4.4-Vantage")
def _noisier(study: Study, first: str, second: str, least: float) -> Finding:
    """ADEV of L and x1 of one type over another's: above 1 at all tau, `least` in the median."""
    one, other = WHOLE[first], WHOLE[second]
    taus = _taus(study, one, other)
    ratios = {s: study.adev(one, s, taus) / study.adev(other, s, taus) for s in ("L", "x1")}
    text = "; ".join(
        f"{s}: {np.median(r):.1f} times ({r.min():.2f} to {r.max():.1f})" for s, r in ratios.items()
    )
    return decided(text, *(r.min() > 1 and bool(np.median(r) > least) for r in ratios.values()))


@decides("S-3.5-tenth")
def _tenth_camera(study: Study) -> Finding:
    ratios = _ten_over_nine(study)
    text = ", ".join(f"{s}: {r:.2f} times" for s, r in ratios.items())
    return decided(text, all(r > 1 for r in ratios.values()))


@decides("S-3.5-extents")
def _intermediate(study: Study) -> Finding:
    ratios = _ten_over_nine(study)
    low, high = sorted((ratios["x1"], ratios["x2"]))
    text = ", ".join(f"{s}: {r:.2f}" for s, r in ratios.items())
    return decided(text, low < ratios["L"] < high)


def _ten_over_nine(study: Study) -> dict[str, float]:
    """ADEV of Vantage with ten cameras over that with nine, geometric mean, by series."""
    taus = np.geomspace(0.01, 1.0, 9)
    names = ("x1", "x2", "L")
    ten, nine = ({s: study.adev(("Vantage", n), s, taus) for s in names} for n in (10, 9))
    return {s: float(np.exp(np.mean(np.log(ten[s] / nine[s])))) for s in names}


@decides("S-4.2-sigma-C")
def _sigma_c(study: Study, percent: float) -> Finding:
    ratios = {}
    for key in SYSTEMS:
        row = study.gaussian(key)
        prefix = "pair_" * ("pair_sigma_L_mm" in row)  # along the line between the markers
        ratios[key[0]] = row[f"{prefix}sigma_L_mm"] / row[f"{prefix}sigma_C_mm"]
    text = ", ".join(f"{name} {r:.3f}" for name, r in ratios.items())
    within = all(abs(r - 1) < percent / 100 for r in ratios.values())
    return decided(f"sigma_L/sigma_C: {text}", within)


@decides("S-4.2-chi-squared")
def _chi_squared(study: Regenerated, least: float) -> Finding:
    from scipy.stats import kstest

    p = [v for key in SUBSETS if np.isfinite(v := study.gaussian(key)["pair_chi2_p"])]
    if len(p) < 5:
        raise Missing("too few tests")
    uniform = float(kstest(p, "uniform").pvalue)
    text = f"p > 0.05 in {share([v > 0.05 for v in p])}; Kolmogorov-Smirnov p {uniform:.2g}"
    return decided(text, uniform > least)


@decides("S-4.2-means")
def _means(study: Study, low: float, high: float) -> Finding:
    lengths = [study.gaussian(key)["mu_L_mm"] for key in SYSTEMS]
    spread = max(lengths) - min(lengths)
    return decided(f"mu_L spans {spread:.2f} mm", low <= spread <= high)


def _sigmas(study: Study) -> tuple[dict[str, tuple[float, float]], dict[str, float]]:
    """(sigma_1, sigma_2) in mm and rho_12 of each type with most cameras."""
    rows = {kind: study.gaussian(WHOLE[kind]) for kind in TYPES}
    sigma = {kind: (row["sigma_1_mm"], row["sigma_2_mm"]) for kind, row in rows.items()}
    return sigma, {kind: row["rho_12"] for kind, row in rows.items()}


@decides("S-4.2-Bonita")
def _bonita_large(study: Study, most: float) -> Finding:
    sigma, rho = _sigmas(study)
    others = zip(sigma["T40"], sigma["Vantage"], strict=True)
    ratio = min(own / max(of) for own, of in zip(sigma["Bonita"], others, strict=True))
    text = f"at least {ratio:.2f} times the others' sigma; rho {rho['Bonita']:.2f}"
    return decided(text, ratio > 1 and abs(rho["Bonita"]) < most)


@decides("S-4.2-T40")
def _t40_correlated(study: Study, least: float) -> Finding:
    sigma, rho = _sigmas(study)
    largest, smallest = max(sigma["T40"]), min(*sigma["Bonita"], *sigma["Vantage"])
    text = f"sigma at most {largest:.4f} mm, others' at least {smallest:.4f} mm"
    good = rho["T40"] > least and largest < smallest
    return decided(f"{text}; rho {rho['T40']:.2f}", good)
