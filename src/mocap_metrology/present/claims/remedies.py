"""Claims of S 3.4, 3.5, 5 and Appendix B: on a shock, a repair, the weights of the fit, filters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, S_ESTIMATOR
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.published import FRAME_RATE_HZ, SERIES
from mocap_metrology.present.claims.claim import (
    COORDINATES,
    DOES_NOT,
    UNKNOWN,
    Claim,
    Finding,
    Published,
    ShockEffect,
    Study,
    by_count,
    decided,
    model_of,
    share,
    subsets,
    unknown,
)
from mocap_metrology.present.skurowski.crump import find_shock

SIDE_S = 300.0  # S: "5 min periods before and after"
ALIKE = 0.05
OF_SIX = 2.64  # standard errors that all of six keep to in 95 %
RAISED = 1.1  # times the Allan deviation without the shock
SHOCK_TAUS_S = np.geomspace(0.02, 20.0, 25)
SHORT_S, LONG_S = 1.0, 10.0  # correlation times that vanish, and that remain
LOW_PASS_HZ = 6.0
NOTCH_HZ = 1.0
FAST_HZ, SLOW_HZ = (1.0, 60.0), (1 / 3600, 0.1)
NODES = 400
ORDINARY = "levenberg-marquardt"


def shock_of(series: Mapping[str, np.ndarray], frame_rate_hz: float) -> ShockEffect | None:
    """Of cleaned coordinates and L (n,) in mm; None where nothing shakes, or near an end.

    The noise of a side is the root mean square of the frames about means of one second, so that a
    random walk between the sides is not taken for noise.
    """
    found = find_shock({s: series[s] for s in COORDINATES}, frame_rate_hz)
    frames = round(SIDE_S * frame_rate_hz)
    if found is None or min(found.start, series["L"].size - found.stop) < frames:
        return None
    m = np.unique(np.maximum(np.round(SHOCK_TAUS_S * frame_rate_hz).astype(np.int64), 1))
    cut = np.array(series["L"], dtype=np.float64)
    cut[found.start : found.stop] = np.nan
    with_it, without = (
        allan_variance(np.asarray(v, float), m).variance for v in (series["L"], cut)
    )
    ratio = np.sqrt(with_it / without)
    sides = {
        s: _noise(series[s][found.stop : found.stop + frames], frame_rate_hz)
        / _noise(series[s][found.start - frames : found.start], frame_rate_hz)
        for s in COORDINATES
    }
    best = int(np.nanargmax(ratio))
    return ShockEffect(float(ratio[best]), float(m[best] / frame_rate_hz), sides, frames)


def _noise(values: np.ndarray, frame_rate_hz: float) -> float:
    block = round(frame_rate_hz)
    blocks = np.asarray(values[: values.size // block * block], float).reshape(-1, block)
    return float(np.sqrt(np.nanmean((blocks - np.nanmean(blocks, axis=1, keepdims=True)) ** 2)))


def _shock(study: Study) -> ShockEffect | Finding:
    if isinstance(study, Published):
        return unknown("Figure 7 has no numbers")
    return study.shock or unknown("no recording with a shock")


def _raises(study: Study) -> Finding:
    found = _shock(study)
    if isinstance(found, Finding):
        return found
    text = f"{found.raised:.2f} times at {found.tau_s:.2g} s"
    return decided(text, found.raised > RAISED)


def _alike(study: Study) -> Finding:
    found = _shock(study)
    if isinstance(found, Finding):
        return found
    error = OF_SIX / np.sqrt(found.frames)
    off = {s: abs(ratio - 1) for s, ratio in found.sides.items()}
    text = ", ".join(f"{s} {ratio:.3f}" for s, ratio in found.sides.items())
    if max(off.values()) + error < ALIKE:
        return decided(f"after over before: {text}", True)
    word = DOES_NOT if max(off.values()) - error > ALIKE else UNKNOWN
    return Finding(f"after over before: {text}", word)


def _vanish(study: Study) -> Finding:
    """Terms of `likelihood` in z1 of every repaired system."""
    if not hasattr(study, "repaired"):
        return unknown("Figure A1 has no numbers")
    if not study.repaired:
        return unknown("no recordings after the repair")
    short, long, lines = 0, 0, 0
    for rows in study.repaired.values():
        found = {
            r["parameter"]: float(r["value"])
            for r in rows
            if (r["series"], r["estimator"], r["status"]) == ("z1", DEFAULT_ESTIMATOR, "ok")
        }
        times = [v for k, v in found.items() if k.startswith("T_c")]
        short += any(t < SHORT_S for t in times)
        long += any(t >= LONG_S for t in times) or "h_-2" in found
        lines += "f_0" in found
    n = len(study.repaired)
    text = f"z1 of {n}: T_c below {SHORT_S:g} s in {short}, from {LONG_S:g} s on or random walk "
    return decided(f"{text}in {long}, a line in {lines}", short == 0 and long > 0 and lines > 0)


def _weighted(study: Study) -> Finding:
    """Root mean square of (AVAR - model) / AVAR of both fits, all averaging times of allan."""
    if isinstance(study, Published):
        return unknown("Figure 6 has no numbers")
    larger, ratios = [], []
    for key in subsets():
        for series in SERIES:
            tau, adev = study.curve(key, series)
            m = np.round(tau * FRAME_RATE_HZ)
            off = {}
            for name in (S_ESTIMATOR, ORDINARY):
                model = NoiseModel.from_coefficients(study.fitted(key, series, name))
                fit = model.avar(m, FRAME_RATE_HZ, "continuous")
                off[name] = float(np.sqrt(np.median((1 - fit / adev**2) ** 2)))
            ratios.append(off[ORDINARY] / off[S_ESTIMATOR])
            larger.append(ratios[-1] > 1)
    text = f"larger with ordinary least squares in {share(larger)}, median {np.median(ratios):.2g}"
    return by_count(f"{text} times", larger, 0.9)


def _low_pass(study: Study) -> Finding:
    """Share of the power that a second-order Butterworth, both ways, keeps above and below."""
    good, kept = [], []
    for key in subsets():
        for series in COORDINATES:
            model = model_of(study, key, series)
            fast, slow = (_share_kept(model, *band) for band in (FAST_HZ, SLOW_HZ))
            kept.append((fast, slow))
            good.append(fast < 0.5 and slow > 0.99)
    fast, slow = np.median(kept, axis=0)
    text = f"retains {100 * fast:.0f} % above 1 Hz, {100 * slow:.1f} % below 0.1 Hz; {share(good)}"
    return by_count(text, good, 0.9)


def _share_kept(model: NoiseModel, low: float, high: float) -> float:
    f = np.geomspace(low, high, NODES)
    psd = model.psd(f, FRAME_RATE_HZ, "continuous")
    gain = (1 + (f / LOW_PASS_HZ) ** 4) ** -2.0
    return float(np.trapezoid(gain * psd, f) / np.trapezoid(psd, f))


def _band_stop(study: Study) -> Finding:
    """What a notch of 1 Hz at the line takes of the other power from 1 Hz on."""
    taken, low = [], 0
    for key in subsets():
        for series in SERIES:
            for f_0, _ in study.lines(key, series):
                if f_0 < FAST_HZ[0] + NOTCH_HZ / 2:
                    low += 1
                    continue
                model = NoiseModel(model_of(study, key, series).broadband)
                f = np.geomspace(*FAST_HZ, NODES)
                inside = np.linspace(f_0 - NOTCH_HZ / 2, f_0 + NOTCH_HZ / 2, NODES)
                whole = np.trapezoid(model.psd(f, FRAME_RATE_HZ, "continuous"), f)
                taken.append(
                    np.trapezoid(model.psd(inside, FRAME_RATE_HZ, "continuous"), inside) / whole
                )
    if not taken:
        return unknown("no periodic term above 1.5 Hz")
    text = f"{100 * max(taken):.1f} % of the noise above 1 Hz at most, {len(taken)} lines"
    return by_count(f"{text}; {low} are too slow", [t < 0.1 for t in taken], 0.9)


GUESS = "the shock (crump) of the twin is assumed: S prints no numbers for it"
CLAIMS: Sequence[Claim[Study]] = (
    Claim(
        "S-3.4-weighted",
        "3.4",
        "weighted least squares follow the whole curve, ordinary ones do not (Figure 6)",
        "median relative residual of levenberg-marquardt over that of annealing-ant-colony",
        "above 1 in nine of ten series",
        _weighted,
        "both from many starts, with the same components",
    ),
    Claim(
        "S-3.5-crump",
        "3.5",
        "a seismic crump has a significant effect on the Allan variance (Figure 7)",
        "ADEV of L with the shock over that without its frames, 0.02 to 20 s, greatest",
        f"above {RAISED:g}",
        _raises,
        GUESS,
    ),
    Claim(
        "S-3.5-sides",
        "3.5",
        "five minutes before and after the crump do not differ",
        "noise within a second after it over that before, six coordinates",
        f"within {100 * ALIKE:.0f} % of 1 in all",
        _alike,
        GUESS,
    ),
    Claim(
        "S-5-low-pass",
        "5",
        "low-pass filters suppress white noise and what is faster, not flicker or random walk",
        (
            f"power of each coordinate's model that a Butterworth filter of {LOW_PASS_HZ:g} Hz "
            "retains"
        ),
        "below half above 1 Hz and above 99 % below 0.1 Hz, in nine of ten",
        _low_pass,
    ),
    Claim(
        "S-5-band-stop",
        "5",
        "band-stop filters deal with periodic noise, if its frequency is not too low",
        f"share of the noise above 1 Hz that a notch of {NOTCH_HZ:g} Hz at each line removes",
        "below a tenth in nine of ten lines",
        _band_stop,
    ),
    Claim(
        "S-B-repair",
        "B",
        "after the repair short correlated noise is gone, periodic and long ones remain",
        f"z1 of each repaired system: T_c below {SHORT_S:g} s; T_c from {LONG_S:g} s on or random "
        "walk; a line",
        "in none; in one at least; in one at least",
        _vanish,
        "twins of the repaired system lack what S reports as gone, so they only show that its "
        "absence can be detected",
    ),
)
