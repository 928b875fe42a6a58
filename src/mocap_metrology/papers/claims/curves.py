"""Claims of S 3 to 5 and B on Allan deviations, moments, a shock, a repair and filters."""

from __future__ import annotations

import numpy as np

from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, S_ESTIMATOR
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.published import FRAME_RATE_HZ, SERIES
from mocap_metrology.papers.claims import study as numbers
from mocap_metrology.papers.claims.decide import Answer, Missing, at_least, decides, share, within
from mocap_metrology.papers.claims.study import SUBSETS, TYPES, WHOLE, Key, Regenerated, Study
from mocap_metrology.papers.shock import ShockEffect

SHORT_S = np.geomspace(0.01, 0.1, 7)
ALL_S = np.geomspace(0.01, 1000.0, 26)
SLOPES = (-1.0, -0.5, 0.0, 0.5)
SYSTEMS = (*WHOLE.values(), ("All", 30))  # rows of Table 4
OF_SIX = 2.64  # standard errors that contain all of six ratios in 95 %
FAST_HZ, SLOW_HZ = (1.0, 60.0), (1 / 3600, 0.1)
NODES = 400
ORDINARY = "levenberg-marquardt"


def _taus(study: Study, *keys: Key) -> np.ndarray:
    """Averaging times up to 1000 s that all of these recordings reach; `Missing` without any."""
    taus = ALL_S[min(study.longest_s(key) for key in keys) >= ALL_S]
    if taus.size < 3:
        raise Missing(f"too short: {keys[0][0]} {keys[0][1]}")
    return taus


@decides("S-4.3-distance-short")
def _distance_above(study: Study, least: float) -> Answer:
    above = [
        bool(np.all(study.adev(key, "L", SHORT_S) > study.adev(key, s, SHORT_S)))
        for key, s in numbers.cases(("x1", "x2"))
    ]
    return f"{share(above)} curves below that of L", at_least(above, least)


@decides("S-4.3-distance-long")
def _distance_below(study: Study, least: float) -> Answer:
    below = []
    for key in SUBSETS:
        taus = _taus(study, key)
        taus = taus[taus >= 1.0]
        most = np.maximum(study.adev(key, "x1", taus), study.adev(key, "x2", taus))
        below += (study.adev(key, "L", taus) <= 1.1 * most).tolist()
    return share(below), at_least(below, least)


@decides("S-4.3-slopes")
def _slopes(study: Study, near: float) -> Answer:
    """Local slopes over a third of a decade, of every subset and series."""
    counts, curves = dict.fromkeys(SLOPES, 0), list(numbers.cases(SERIES))
    for key, series in curves:
        taus = _taus(study, key)
        level = np.log(study.adev(key, series, taus))
        local = (level[2:] - level[:-2]) / (np.log(taus[1] / taus[0]) * 2)
        for slope in SLOPES:
            counts[slope] += bool(np.any(np.abs(local - slope) < near))
    text = ", ".join(f"{slope:+g} in {count}" for slope, count in counts.items())
    return f"{text} of {len(curves)} curves", all(counts.values())


@decides("S-4.3-walk")
def _random_walk(study: Study, least: float) -> Answer:
    """Share of h_-2 in AVAR at 1000 s, and its share with T_c of 1000 s and more (same shape)."""
    models = [numbers.model_of(study, *case) for case in numbers.cases()]
    there = [numbers.share_of_avar(m, 1000.0, (-2,)) > 0.1 for m in models]
    alike = [numbers.share_of_avar(m, 1000.0, (-2,), 1000.0) > 0.1 for m in models]
    text = f"h_-2 in {share(there)}; including correlated noise of 1000 s and more {share(alike)}"
    return text, at_least(there, least)


@decides("S-4.4-Bonita", "S-4.4-Vantage")
def _noisier(study: Study, first: str, second: str, least: float) -> Answer:
    """ADEV of L and x1 of one type over another's: above 1 at all tau, `least` in the median."""
    taus = _taus(study, WHOLE[first], WHOLE[second])
    one, other = ({s: study.adev(WHOLE[k], s, taus) for s in ("L", "x1")} for k in (first, second))
    ratios = {s: one[s] / other[s] for s in one}
    text = "; ".join(
        f"{s}: {np.median(r):.1f} times ({r.min():.2f} to {r.max():.1f})" for s, r in ratios.items()
    )
    return text, *(r.min() > 1 and np.median(r) > least for r in ratios.values())


def _ten_over_nine(study: Study) -> dict[str, float]:
    """ADEV of Vantage with ten cameras over that with nine, geometric mean, by series."""
    taus = np.geomspace(0.01, 1.0, 9)
    ten, nine = (
        {s: study.adev(("Vantage", n), s, taus) for s in ("x1", "x2", "L")} for n in (10, 9)
    )
    return {s: float(np.exp(np.mean(np.log(ten[s] / nine[s])))) for s in ten}


@decides("S-3.5-tenth")
def _tenth_camera(study: Study) -> Answer:
    ratios = _ten_over_nine(study)
    text = ", ".join(f"{s}: {r:.2f} times" for s, r in ratios.items())
    return text, all(r > 1 for r in ratios.values())


@decides("S-3.5-extents")
def _intermediate(study: Study) -> Answer:
    ratios = _ten_over_nine(study)
    low, high = sorted((ratios["x1"], ratios["x2"]))
    return ", ".join(f"{s}: {r:.2f}" for s, r in ratios.items()), low < ratios["L"] < high


@decides("S-4.2-sigma-C")
def _sigma_c(study: Study, percent: float) -> Answer:
    ratios = {}
    for key in SYSTEMS:
        row = study.gaussian(key)
        prefix = "pair_" * ("pair_sigma_L_mm" in row)  # along the line between the markers
        ratios[key[0]] = row[f"{prefix}sigma_L_mm"] / row[f"{prefix}sigma_C_mm"]
    text = ", ".join(f"{name} {r:.3f}" for name, r in ratios.items())
    near = all(abs(r - 1) < percent / 100 for r in ratios.values())
    return f"sigma_L/sigma_C: {text}", near


@decides("S-4.2-chi-squared")
def _chi_squared(study: Regenerated, least: float) -> Answer:
    from scipy.stats import kstest

    p = [v for key in SUBSETS if np.isfinite(v := study.gaussian(key)["pair_chi2_p"])]
    if len(p) < 5:
        raise Missing("too few tests")
    uniform = float(kstest(p, "uniform").pvalue)
    passed = share([v > 0.05 for v in p])
    return f"p > 0.05 in {passed}; Kolmogorov-Smirnov p {uniform:.2g}", uniform > least


@decides("S-4.2-means")
def _means(study: Study, low: float, high: float) -> Answer:
    lengths = [study.gaussian(key)["mu_L_mm"] for key in SYSTEMS]
    spread = max(lengths) - min(lengths)
    return f"mu_L spans {spread:.2f} mm", low <= spread <= high


def _sigmas(study: Study) -> tuple[dict[str, tuple[float, float]], dict[str, float]]:
    """(sigma_1, sigma_2) in mm and rho_12 of each type with most cameras."""
    rows = {kind: study.gaussian(WHOLE[kind]) for kind in TYPES}
    sigma = {kind: (row["sigma_1_mm"], row["sigma_2_mm"]) for kind, row in rows.items()}
    return sigma, {kind: row["rho_12"] for kind, row in rows.items()}


@decides("S-4.2-Bonita")
def _bonita_large(study: Study, most: float) -> Answer:
    sigma, rho = _sigmas(study)
    others = zip(sigma["T40"], sigma["Vantage"], strict=True)
    ratio = min(s / max(pair) for s, pair in zip(sigma["Bonita"], others, strict=True))
    text = f"at least {ratio:.2f} times the others' sigma; rho {rho['Bonita']:.2f}"
    return text, ratio > 1 and abs(rho["Bonita"]) < most


@decides("S-4.2-T40")
def _t40_correlated(study: Study, least: float) -> Answer:
    sigma, rho = _sigmas(study)
    largest, smallest = max(sigma["T40"]), min(*sigma["Bonita"], *sigma["Vantage"])
    text = f"sigma at most {largest:.4f} mm, others' at least {smallest:.4f} mm"
    return f"{text}; rho {rho['T40']:.2f}", rho["T40"] > least and largest < smallest


def _shock(study: Regenerated) -> ShockEffect:
    if study.shock is None:
        raise Missing("no recording with a shock")
    return study.shock


@decides("S-3.5-crump")
def _raised(study: Regenerated, least: float) -> Answer:
    shock = _shock(study)
    return f"{shock.raised:.2f} times at {shock.tau_s:.2g} s", shock.raised > least


@decides("S-3.5-sides")
def _sides_alike(study: Regenerated, percent: float) -> Answer:
    shock = _shock(study)
    error, limit = OF_SIX / np.sqrt(shock.frames), percent / 100
    text = ", ".join(f"{s} {ratio:.3f}" for s, ratio in shock.sides.items())
    words = [within(ratio, error, 1 - limit, 1 + limit) for ratio in shock.sides.values()]
    return f"after over before: {text}", *words


@decides("S-B-repair")
def _repaired(study: Regenerated, short_s: float, long_s: float) -> Answer:
    """Terms of `likelihood` in z1 of every repaired system."""
    if not study.repaired:
        raise Missing("no recordings after the repair")
    short, long, lines = 0, 0, 0
    for rows in study.repaired.values():
        values = {
            r["parameter"]: float(r["value"])
            for r in rows
            if (r["series"], r["estimator"], r["status"]) == ("z1", DEFAULT_ESTIMATOR, "ok")
        }
        times = [v for k, v in values.items() if k.startswith("T_c")]
        short += any(t < short_s for t in times)
        long += any(t >= long_s for t in times) or "h_-2" in values
        lines += "f_0" in values
    text = f"z1 of {len(study.repaired)}: T_c below {short_s} s in {short}, "
    text += f"of {long_s} s or more, or random walk, in {long}, a line in {lines}"
    return text, short == 0, long > 0, lines > 0


@decides("S-3.4-weighted")
def _weighted(study: Regenerated, least: float) -> Answer:
    """Median of |AVAR - model| / AVAR over all averaging times: ordinary over weighted fits."""
    ratios = []
    for key, series in numbers.cases(SERIES):
        tau, adev = study.curve(key, series)
        ordinary, weighted = (
            np.median(np.abs(1 - numbers.avar(NoiseModel.from_coefficients(fit), tau) / adev**2))
            for fit in (study.fitted(key, series, name) for name in (ORDINARY, S_ESTIMATOR))
        )
        ratios.append(float(ordinary / weighted))
    larger = [r > 1 for r in ratios]
    text = f"larger with ordinary least squares in {share(larger)}, median {np.median(ratios):.2g}"
    return f"{text} times", at_least(larger, least)


@decides("S-5-low-pass")
def _low_pass(study: Study, cutoff_hz: float, least: float) -> Answer:
    """Share of the power that a second-order Butterworth filter, run both ways, retains."""
    retained = []
    for case in numbers.cases():
        model, shares = numbers.model_of(study, *case), []
        for low, high in (FAST_HZ, SLOW_HZ):
            f = np.geomspace(low, high, NODES)
            psd = model.psd(f, FRAME_RATE_HZ)
            gain = (1 + (f / cutoff_hz) ** 4) ** -2.0
            shares.append(float(np.trapezoid(gain * psd, f) / np.trapezoid(psd, f)))
        retained.append(shares)
    good = [fast < 0.5 and slow > 0.99 for fast, slow in retained]
    fast, slow = np.median(retained, axis=0)
    text = f"retains {100 * fast:.0f} % above 1 Hz, {100 * slow:.1f} % below 0.1 Hz; {share(good)}"
    return text, at_least(good, least)


@decides("S-5-band-stop")
def _band_stop(study: Study, notch_hz: float, most: float, least: float) -> Answer:
    """Share of the other power above 1 Hz that a notch at the line removes."""
    removed, low = [], 0
    for key, series in numbers.cases(SERIES):
        for f_0, _ in study.lines(key, series):
            if f_0 < FAST_HZ[0] + notch_hz / 2:
                low += 1
                continue
            model = numbers.model_of(study, key, series)
            f = np.geomspace(*FAST_HZ, NODES)
            inside = np.linspace(f_0 - notch_hz / 2, f_0 + notch_hz / 2, NODES)
            power, of_notch = (np.trapezoid(model.psd(v, FRAME_RATE_HZ), v) for v in (f, inside))
            removed.append(float(of_notch / power))
    if not removed:
        raise Missing("no periodic term above 1.5 Hz")
    text = f"{100 * max(removed):.1f} % of the noise above 1 Hz at most, {len(removed)} lines"
    return f"{text}; {low} are too slow", at_least([r < most for r in removed], least)
