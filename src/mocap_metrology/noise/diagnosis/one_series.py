"""One series of a recording without its events: what kind of wander, lines, filters it has."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.hampel import SAMPLED, own_step
from mocap_metrology.noise.diagnosis.block_means import block_length
from mocap_metrology.noise.diagnosis.export import Resolution, hiding_step, resolution
from mocap_metrology.noise.diagnosis.filtering import Filtered, filters, middle, tried
from mocap_metrology.noise.diagnosis.periodic import SpectralLine, described, series_lines
from mocap_metrology.noise.diagnosis.records import DiagnosisSettings, Recording
from mocap_metrology.noise.diagnosis.resonance import MOST_GAPS, Resonance, resonance
from mocap_metrology.noise.diagnosis.signatures import WALK, Wander, signature
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, NoiseRow, model_of
from mocap_metrology.noise.fit.spectral.gaps import filled
from mocap_metrology.noise.fit.spectral.likelihood import (
    LONGEST_GAP,
    LikelihoodSettings,
    likelihood,
)
from mocap_metrology.noise.fit.spectral.welch import welch
from mocap_metrology.noise.model.components import Form, NoiseModel, Sinusoid

PICOMETRES = 9  # digits of mm; without a shape, equal values of a coarse file are equal again
NOTCHES = 3  # of a series: its strongest lines
SLOW_HZ = 0.25  # lines below may be of what a change at once leaves
BOUNDED = 0.2  # of the recording, T_c of the slowest rival of a walk
LEAST_PERIOD = 8  # blocks, of a cycle that the signatures have
Columns = Mapping[str, np.ndarray]
Density = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Examined:
    """What was found in one series without its events."""

    name: str
    spectrum: dict[str, np.ndarray] | None
    lines: list[SpectralLine]
    filtered: list[Filtered]
    step: Resolution
    wander: Wander | None
    resonance: Resonance | None


@dataclass(frozen=True)
class Examiner:
    """What every series of a recording is examined with; away: frames inside events; noise, psd: as
    of `diagnose`."""

    recording: Recording
    settings: DiagnosisSettings
    n_series: int
    away: np.ndarray
    noise: Sequence[NoiseRow]
    psd: Columns | None
    welch: Mapping[str, float]

    def examined(self, one: tuple[str, np.ndarray]) -> Examined:
        """A series by its name."""
        name, series = one
        distance, step_mm = name.startswith("L"), self.recording.step_mm
        rate, blank = self.recording.frame_rate_hz, without_frames(series, self.away)
        coarse = hiding_step(blank, step_mm, distance)
        wander = signature(blank, rate, self.n_series)
        jumps = bool(wander and wander.jumps)
        if wander:
            blank = wander.without_jumps(blank, rate)
        model, spectrum = _model(self.noise, name), _rows(self.psd, name)
        if jumps or self.away.any():
            model = _refitted(blank, series, rate, model)
        density = partial(model.psd, frame_rate_hz=rate) if model else None
        if density and 0 < np.isnan(blank).mean() <= MOST_GAPS:
            spectrum = _welch(_gapless(blank, density, rate), rate, self.welch)
        elif jumps or self.away.any():
            spectrum = _welch(blank, rate, self.welch)
        length, lowest = block_length(series.size, rate), 0.0
        if wander and (wander.jumps or wander.kinds or wander.undecided):  # slower ones may be its
            lowest = SLOW_HZ if wander.jumps else rate / (LEAST_PERIOD * length)
        least = lowest, coarse / 2
        lines, filtered = self._lines_and_filters(name, blank, density, spectrum, least)
        folded = left_in_means(lines, length, rate)
        wander = wander and wander.beyond(max(coarse, folded))
        steps = np.diff(blank)
        steps = steps[np.isfinite(steps)]
        avar_1 = float(np.mean(steps**2)) / 2 if steps.size else math.nan
        least_step = max(step_mm, 0.0 if distance else multiples_of(blank))
        kind = self.recording.resolution_kind if least_step <= 2 * step_mm else "rounded"
        step = resolution(name, least_step, kind, avar_1, rate, distance)
        at_hz = [one.line.f_0 for one in lines if not one.wanders]
        broad = resonance(name, blank, rate, spectrum, at_hz) if spectrum else None
        return Examined(name, spectrum, lines, filtered, step, wander, broad)

    def _lines_and_filters(
        self,
        name: str,
        series: np.ndarray,
        density: Density | None,
        spectrum: Columns | None,
        least: tuple[float, float],
    ) -> tuple[list[SpectralLine], list[Filtered]]:
        """Lines beyond this frequency and amplitude."""
        settings, rate = self.settings, self.recording.frame_rate_hz
        every, part = series_lines(series, rate, settings.max_lines, density, self.n_series)
        lines = [line for line in every if line.f_0 > least[0] and line.A_s > least[1]]
        notches = [line.f_0 for line in lines[:NOTCHES]]
        among = filters(rate, settings.cutoffs_hz, notches, settings.notch_width_hz)
        sinusoids = [Sinusoid(line.A_s, line.f_0) for line in every]
        return (
            described(name, lines, part, rate, spectrum),
            tried(name, series, rate, among, density, sinusoids),
        )


def multiples_of(series: np.ndarray) -> float:
    """`own_step` of (n,) values whose changes are multiples of it, as those beyond a dead band are
    not; else 0."""
    step, changes = own_step(series), np.diff(middle(series)[:SAMPLED])
    often = changes[np.isfinite(changes) & (changes != 0)] / (step or math.inf)
    return step if step and np.mean(np.abs(often - np.rint(often)) < 0.1) > 0.9 else 0.0


def left_in_means(lines: Sequence[SpectralLine], length: int, rate_hz: float) -> float:
    """What lines leave in means of `length` frames, mm, at most: A |sin(pi f l tau0) / (l sin(pi f
    tau0))| to both sides, at the lower, middle and upper frequency of those that are faster."""
    total = 0.0
    for one in (x.line for x in lines if x.line.f_0 * length > rate_hz / 2):
        f = (one.f_0 + one.width_f * np.array([-1, 0, 1])) / rate_hz
        total += 2 * one.A_s * float(np.abs(np.sinc(length * f) / np.sinc(f)).max())
    return total


def without_frames(series: np.ndarray, away: np.ndarray) -> np.ndarray:
    """A copy as float64, NaN where `away`."""
    blank = series.astype(np.float64)
    blank[away] = np.nan
    return blank


def _likelihood_rows(noise: Sequence[NoiseRow], series: str) -> list[NoiseRow]:
    return [r for r in noise if r["series"] == series and r["estimator"] == DEFAULT_ESTIMATOR]


def _model(noise: Sequence[NoiseRow], series: str) -> NoiseModel | None:
    """The likelihood's model of a series, or None without one."""
    rows = _likelihood_rows(noise, series)
    model = model_of(rows) if any(r["status"] != "refused" for r in rows) else None
    return model if model and model.broadband else None


def decided(wanders: Mapping[str, Wander], noise: Sequence[NoiseRow]) -> dict[str, Wander]:
    """No noise that is named where a walk is of another noise by the signature, or its interval
    holds zero, or it may be bounded (`_bounded`), as slow Gauss-Markov noise may stand for it; and
    no straight line where the noise model has an approach beside it, or none, as its slope is not
    that of the movement then."""
    bounded = _bounded([one.slowest for one in wanders.values() if one.slowest is not None])

    def of(series: str, wander: Wander) -> Wander:
        rows = _likelihood_rows(noise, series)
        known = {r["parameter"] for r in rows if r["status"] != "not_detected"}
        bent = "A_w" in known and "warm_up" not in wander.kinds
        if wander.kinds == ("drift",) and (bent or "drift" not in known):
            wander = replace(wander, kinds=(), noise="", possible=("drift",))
        lowest = [float(r["lower_95"]) for r in rows if r["parameter"] == "h_-2"]
        least = min((low for low in lowest if math.isfinite(low)), default=1.0)
        walk = wander.noise == "random_walk"
        if not wander.noise or (least > 0 and not bounded if walk else not lowest):
            return wander
        return replace(wander, noise="", possible=wander.possible or ("noise",))

    return {name: of(name, one) for name, one in wanders.items()}


def _bounded(slowest: Sequence[np.ndarray]) -> bool:
    """Whether walks (see `_slowest`) may be noise correlated over a fifth of the recording, by all
    series together: it has x^2 / (1 + x^2) of the variance of the differences of a walk, x = 2
    pi f T_c. Series that share a movement count for as few as their correlation leaves."""
    if not slowest:
        return True
    amplitudes, share = np.stack(slowest, axis=1)
    x = np.pi * BOUNDED * np.arange(1, amplitudes.shape[1] + 1)
    left = 1 - share / (1 + x**2)
    odds = np.sum(amplitudes**2 * (1 / left - 1) + np.log(left), axis=1) / 2
    alike = float(np.sum(np.corrcoef(amplitudes) ** 2))
    return float(odds.sum()) * len(slowest) / alike < -math.log(WALK)


def _welch(
    series: np.ndarray, rate_hz: float, settings: Mapping[str, float]
) -> dict[str, np.ndarray] | None:
    try:
        spectrum = welch(series, rate_hz, **settings)
    except Refusal:
        return None
    n = np.full(spectrum.f_hz.size, spectrum.n_segments)
    return {"f_hz": spectrum.f_hz, "psd_mm2_hz": spectrum.psd, "n_segments": n}


def _gapless(
    series: np.ndarray, density: Callable[[np.ndarray], np.ndarray], rate_hz: float
) -> np.ndarray:
    """Gaps filled with noise, as straight lines over them have a spectrum of their own."""
    inside = middle(series)
    there = np.flatnonzero(np.isfinite(inside))
    inside = inside[there[0] : there[-1] + 1]
    return filled(inside, density, rate_hz, np.random.default_rng(0))


def _refitted(
    blank: np.ndarray, series: np.ndarray, rate_hz: float, before: NoiseModel | None
) -> NoiseModel | None:
    """The model of a series of which `blank` has left frames out; else the one before. They become
    gaps so long that the likelihood parts the series there and fills nothing."""
    from scipy.ndimage import maximum_filter1d

    left_out = np.isnan(blank) & ~np.isnan(series)
    wide = maximum_filter1d(left_out.view(np.uint8), LONGEST_GAP + 1).view(bool)
    form: Form = before.form if before else "sampled"
    cleaned = np.round(without_frames(middle(blank), middle(wide)), PICOMETRES)
    try:
        model = likelihood(cleaned, rate_hz, None, LikelihoodSettings(form=form)).estimate.model
    except Refusal:
        return before
    return model if model.broadband else before


def _rows(columns: Columns | None, series: str) -> dict[str, np.ndarray] | None:
    """The rows of one series, without the column of its name; None where there are none."""
    if columns is None:
        return None
    keep = columns["series"] == series
    return {k: v[keep] for k, v in columns.items() if k != "series"} if keep.any() else None
