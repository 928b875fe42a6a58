"""A shock of a recording (S Figure 7, there a crump), and its effect on the Allan deviation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mocap_metrology.noise.allan.variance import allan_variance

LAG_S, WINDOW_S = 0.1, 0.5
TIMES = 2.0  # shaken: so many times the usual square of a movement over LAG_S
BEFORE_S, AFTER_S = 5.0, 25.0  # shown round the shock
AXES = ("x1", "y1", "z1")
RECORDED, CLEANED, CUT = "as recorded", "after the Hampel filter", "shock cut out"
SIDE_S = 300.0  # S: "5 min periods before and after"
TAUS_S = np.geomspace(0.02, 20.0, 25)


@dataclass(frozen=True)
class Shock:
    """Frames `start` to `stop` (exclusive) round the strongest shake, half a window early;
    `onset`: frame where it begins."""

    start: int
    onset: int
    stop: int


def find_shock(series: Mapping[str, np.ndarray], frame_rate_hz: float) -> Shock | None:
    """The strongest shake of all series together, None where nothing ever moves.

    Squares of the movements over a tenth of a second, each series' by its own median, averaged over
    series and half a second; a shake lasts as long as that stays above twice its own median.
    """
    lag = max(round(LAG_S * frame_rate_hz), 1)
    window = max(round(WINDOW_S * frame_rate_hz), 1)
    total, count = np.zeros(0), 0
    for values in series.values():
        moved = np.square(values[lag:] - values[:-lag])
        known = moved[np.isfinite(moved)]
        usual = float(np.median(known)) if known.size else 0.0
        if usual > 0:
            shaken = np.nan_to_num(moved / usual)
            total, count = (total + shaken if count else shaken), count + 1
    if not count or total.size < 2 * window:
        return None
    level = np.convolve(total / count, np.full(window, 1 / window), mode="same")
    usual = float(np.median(level))
    peak = int(np.argmax(level))
    calm = np.flatnonzero(level <= TIMES * usual)
    place = int(np.searchsorted(calm, peak))
    start = int(calm[place - 1]) + 1 if place else 0
    stop = int(calm[place]) if place < calm.size else level.size
    onset = min(start + lag + window // 2, peak)
    return Shock(start, onset, max(stop, start + 1) + lag)


@dataclass(frozen=True)
class ShockRecording:
    """A recording with a shock: raw and cleaned coordinates and L, (n,) mm each, by name, and
    columns of allan.parquet, which are of the cleaned ones."""

    raw: Mapping[str, np.ndarray]
    clean: Mapping[str, np.ndarray]
    allan: Mapping[str, np.ndarray]
    frame_rate_hz: float
    min_coverage: float = 0.5

    def curves(self, shock: Shock | None) -> pd.DataFrame:
        """Allan deviation of L, `y` in mm at `x` in s: as recorded, after cleaning, and after
        cleaning without the frames of the shock; `curve`: which."""
        mask = (self.allan["series"] == "L") & (self.allan["estimator"] == "oadev")
        tau, adev = (self.allan[key][mask].astype(float) for key in ("tau_s", "adev_mm"))
        cut = np.array(self.clean["L"], dtype=np.float64)
        if shock is not None:
            cut[shock.start : shock.stop] = np.nan

        def of(values: np.ndarray) -> np.ndarray:
            m = self.allan["m"][mask].astype(np.int64)
            return np.sqrt(allan_variance(values, m, min_coverage=self.min_coverage).variance)

        deviations = {RECORDED: of(self.raw["L"]), CLEANED: adev}
        deviations |= {} if shock is None else {CUT: of(cut)}
        frames = [pd.DataFrame({"curve": k, "x": tau, "y": y}) for k, y in deviations.items()]
        return pd.concat(frames, ignore_index=True).assign(lower=np.nan, upper=np.nan)

    def traces(self, at: int) -> dict[str, pd.DataFrame]:
        """Marker 1 round frame `at`: `time_s` from there, `raw` and `clean` in µm about the median
        of the raw, by series."""
        first = max(at - round(BEFORE_S * self.frame_rate_hz), 0)
        part = slice(first, at + round(AFTER_S * self.frame_rate_hz))
        traces = {}
        for series in AXES:
            both = {"raw": self.raw[series][part], "clean": self.clean[series][part]}
            table = pd.DataFrame(both, dtype=np.float64)
            table = 1e3 * (table - np.nan_to_num(table["raw"].median()))
            traces[series] = table.assign(time_s=(table.index + first - at) / self.frame_rate_hz)
        return traces

    def replaced(self, shock: Shock) -> tuple[int, int]:
        """How many samples of marker 1 in the shock a filter of single outliers replaced, of how
        many."""
        part = slice(shock.start, shock.stop)
        changed = [self.raw[s][part] != self.clean[s][part].astype(np.float64) for s in AXES]
        return int(np.count_nonzero(changed)), int(np.size(changed))


@dataclass(frozen=True)
class ShockEffect:
    """Greatest ratio of the Allan deviations of L with the shock and without its frames, and its
    tau (s); by coordinate the noise after the shock over that before it, in so many frames."""

    raised: float
    tau_s: float
    sides: Mapping[str, float]
    frames: int


def shock_effect(series: Mapping[str, np.ndarray], frame_rate_hz: float) -> ShockEffect | None:
    """The effect of the shock on cleaned coordinates and L (n,) in mm; None without a shock, or
    with one near an end.

    The noise of a side is the root mean square of the frames about means of one second, so that a
    random walk between the sides does not count as noise.
    """
    coordinates = {name: values for name, values in series.items() if name != "L"}
    shock = find_shock(coordinates, frame_rate_hz)
    frames = round(SIDE_S * frame_rate_hz)
    if shock is None or min(shock.start, series["L"].size - shock.stop) < frames:
        return None
    m = np.unique(np.maximum(np.round(TAUS_S * frame_rate_hz).astype(np.int64), 1))
    cut = np.array(series["L"], dtype=np.float64)
    cut[shock.start : shock.stop] = np.nan
    with_it, without = (
        allan_variance(np.asarray(v, float), m).variance for v in (series["L"], cut)
    )
    ratio = np.sqrt(with_it / without)
    sides = {
        name: _noise(values[shock.stop : shock.stop + frames], frame_rate_hz)
        / _noise(values[shock.start - frames : shock.start], frame_rate_hz)
        for name, values in coordinates.items()
    }
    best = int(np.nanargmax(ratio))
    return ShockEffect(float(ratio[best]), float(m[best] / frame_rate_hz), sides, frames)


def _noise(values: np.ndarray, frame_rate_hz: float) -> float:
    block = round(frame_rate_hz)
    blocks = np.asarray(values[: values.size // block * block], float).reshape(-1, block)
    return float(np.sqrt(np.nanmean((blocks - np.nanmean(blocks, axis=1, keepdims=True)) ** 2)))
