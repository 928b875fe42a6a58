"""Claims of S 3.4, 3.5, 5 and Appendix B: on a shock, a repair, the weights of the fit, filters."""

from __future__ import annotations

import numpy as np

from mocap_metrology.noise.diagnosis.shock import ShockEffect
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, S_ESTIMATOR
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.published import FRAME_RATE_HZ, SERIES
from mocap_metrology.present.claims.claim import (
    Finding,
    Missing,
    Rules,
    at_least,
    decided,
    share,
    within,
)
from mocap_metrology.present.claims.study import Regenerated, Study, avar, cases, model_of

decides = Rules()
OF_SIX = 2.64  # standard errors that contain all of six ratios in 95 %
FAST_HZ, SLOW_HZ = (1.0, 60.0), (1 / 3600, 0.1)
NODES = 400
ORDINARY = "levenberg-marquardt"


def _shock(study: Regenerated) -> ShockEffect:
    if study.shock is None:
        raise Missing("no recording with a shock")
    return study.shock


@decides("S-3.5-crump")
def _raises(study: Regenerated, least: float) -> Finding:
    found = _shock(study)
    return decided(f"{found.raised:.2f} times at {found.tau_s:.2g} s", found.raised > least)


@decides("S-3.5-sides")
def _alike(study: Regenerated, percent: float) -> Finding:
    found = _shock(study)
    error, limit = OF_SIX / np.sqrt(found.frames), percent / 100
    text = ", ".join(f"{s} {ratio:.3f}" for s, ratio in found.sides.items())
    words = [within(ratio, error, 1 - limit, 1 + limit) for ratio in found.sides.values()]
    return decided(f"after over before: {text}", *words)


@decides("S-B-repair")
def _vanish(study: Regenerated, short_s: float, long_s: float) -> Finding:
    """Terms of `likelihood` in z1 of every repaired system."""
    if not study.repaired:
        raise Missing("no recordings after the repair")
    short, long, lines = 0, 0, 0
    for rows in study.repaired.values():
        found = {
            r["parameter"]: float(r["value"])
            for r in rows
            if (r["series"], r["estimator"], r["status"]) == ("z1", DEFAULT_ESTIMATOR, "ok")
        }
        times = [v for k, v in found.items() if k.startswith("T_c")]
        short += any(t < short_s for t in times)
        long += any(t >= long_s for t in times) or "h_-2" in found
        lines += "f_0" in found
    text = f"z1 of {len(study.repaired)}: T_c below {short_s} s in {short}, "
    text += f"of {long_s} s or more, or random walk, in {long}, a line in {lines}"
    return decided(text, short == 0, long > 0, lines > 0)


@decides("S-3.4-weighted")
def _weighted(study: Regenerated, least: float) -> Finding:
    """Median of |AVAR - model| / AVAR over all averaging times: ordinary over weighted fits."""
    ratios = []
    for key, series in cases(SERIES):
        tau, adev = study.curve(key, series)
        off = {}
        for name in (S_ESTIMATOR, ORDINARY):
            model = NoiseModel.from_coefficients(study.fitted(key, series, name))
            off[name] = float(np.median(np.abs(1 - avar(model, tau) / adev**2)))
        ratios.append(off[ORDINARY] / off[S_ESTIMATOR])
    larger = [r > 1 for r in ratios]
    text = f"larger with ordinary least squares in {share(larger)}, median {np.median(ratios):.2g}"
    return decided(f"{text} times", at_least(larger, least))


@decides("S-5-low-pass")
def _low_pass(study: Study, cutoff_hz: float, least: float) -> Finding:
    """Share of the power that a second-order Butterworth filter, run both ways, retains."""
    retained = []
    for case in cases():
        model, shares = model_of(study, *case), []
        for low, high in (FAST_HZ, SLOW_HZ):
            f = np.geomspace(low, high, NODES)
            psd = model.psd(f, FRAME_RATE_HZ)
            gain = (1 + (f / cutoff_hz) ** 4) ** -2.0
            shares.append(float(np.trapezoid(gain * psd, f) / np.trapezoid(psd, f)))
        retained.append(shares)
    good = [fast < 0.5 and slow > 0.99 for fast, slow in retained]
    fast, slow = np.median(retained, axis=0)
    text = f"retains {100 * fast:.0f} % above 1 Hz, {100 * slow:.1f} % below 0.1 Hz; {share(good)}"
    return decided(text, at_least(good, least))


@decides("S-5-band-stop")
def _band_stop(study: Study, notch_hz: float, most: float, least: float) -> Finding:
    """Share of the other power above 1 Hz that a notch at the line removes."""
    removed, low = [], 0
    for key, series in cases(SERIES):
        for f_0, _ in study.lines(key, series):
            if f_0 < FAST_HZ[0] + notch_hz / 2:
                low += 1
                continue
            model = model_of(study, key, series)
            f = np.geomspace(*FAST_HZ, NODES)
            inside = np.linspace(f_0 - notch_hz / 2, f_0 + notch_hz / 2, NODES)
            power, of_notch = (np.trapezoid(model.psd(v, FRAME_RATE_HZ), v) for v in (f, inside))
            removed.append(float(of_notch / power))
    if not removed:
        raise Missing("no periodic term above 1.5 Hz")
    text = f"{100 * max(removed):.1f} % of the noise above 1 Hz at most, {len(removed)} lines"
    return decided(f"{text}; {low} are too slow", at_least([r < most for r in removed], least))
