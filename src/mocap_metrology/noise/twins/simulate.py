"""Simulated recordings ("twins") of two markers, from noise coefficients.

    twin = Twin("T40-10", 1, **vars(of_published("T40", 10)))
    recording = simulate(twin)                       # nine hours, its own seed
    recording.position_mm                            # (2 markers, 3 axes, n frames)

The Allan variance of every coordinate is its model's at every tau (`synthesis` says how), in the
twin's `form`; that of the distance too, wherever the models of x1, x2 and L do not contradict each
other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TypedDict
from zlib import crc32

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.large import Scratch
from mocap_metrology.common.types import Row
from mocap_metrology.noise.model.synthesis import Cross, Shared, clipped_bands, coherence, draw_pair
from mocap_metrology.noise.twins.twin import COORDINATES, Twin

__all__ = [
    "SimulatedRecording",
    "Twin",
    "clipped_bands",
    "coherence",
    "simulate",
]

AXES = ("x", "y", "z")
SWINGS = 20  # a crump is followed for so many decay times: exp(-20) = 2e-9


@dataclass(frozen=True)
class SimulatedRecording:
    """`position_mm` (2 markers, 3 axes, n frames), NaN in gaps; `truth`, ready for JSON, states
    what went in: coefficients, clipped bands, outliers, crump, gaps, notes."""

    frame_rate_hz: float
    position_mm: np.ndarray
    truth: Row


class _Line(TypedDict):
    """A sinusoid as added to the coordinate `series`; `of`: the requested one."""

    of: str
    series: str
    amplitude_mm: float
    f_0_hz: float
    phase_rad: float


def stream(twin_name: str, seed: int, purpose: str) -> np.random.Generator:
    """PCG64 of SeedSequence([seed, crc32(twin name), crc32(purpose)]): every twin and, within it,
    every purpose (`x`, `y`, `z`, `phases`, `outliers`, `crump`, `gaps`) has a stream of its own,
    so nothing depends on the order of drawing, and adding outliers leaves the noise as it was."""
    words = [seed, crc32(twin_name.encode()), crc32(purpose.encode())]
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(words)))


def simulate(
    twin: Twin,
    duration_s: float | None = None,
    seed: int | None = None,
    folder: str | Path | None = None,
) -> SimulatedRecording:
    """Simulate `twin` for `duration_s` (default: its own) with `seed` (default: its own).

    Noise starts at 0 in the first frame, so the recording starts at `twin.start_mm`; its means
    differ from that by what the noise does. Same twin, duration and seed: same bytes (on one
    build of numpy and scipy). folder: where a large recording waits while it is made. Raises
    `Refusal` for less than 16 frames.
    """
    duration = twin.duration_s if duration_s is None else duration_s
    seed = twin.seed if seed is None else seed
    n = round(duration * twin.frame_rate_hz)
    if n < 16:
        raise Refusal(f"twin {twin.name}: duration {duration:g} s, expected 16 frames at least")
    scratch = Scratch((2, 3, n), folder)
    position = scratch.values
    lines = _add_noise(scratch, twin, seed)
    position += np.asarray(twin.start_mm)[:, :, None]
    hours = np.arange(n) / (3600 * twin.frame_rate_hz)
    for label, velocity in twin.drift_mm_per_h.items():
        for axis, v in enumerate(velocity):
            position[twin.labels.index(label), axis] += v * hours
    truth = _origin(twin, seed, n) | {"sinusoids": lines}
    truth["crump"] = _add_crump(position, twin, seed)
    truth["outliers"] = _add_outliers(position, twin, seed)
    if twin.resolution_mm:
        for own in position.reshape(-1, n):
            np.round(own / twin.resolution_mm, out=own)
            own *= twin.resolution_mm
    truth["gaps"] = _cut_gaps(position, twin, seed)
    return SimulatedRecording(twin.frame_rate_hz, position, truth)


def _add_noise(scratch: Scratch, twin: Twin, seed: int) -> list[Row]:
    """Fill the scratch with noise that starts at 0; return the sinusoids that went in."""
    position = scratch.values
    n, tau0 = position.shape[2], 1 / twin.frame_rate_hz
    for axis, letter in enumerate(AXES):
        first, second = (twin.models[f"{letter}{marker}"] for marker in (1, 2))
        if letter == "x":
            cross = Cross(twin.models.get("L"), twin.coherence_factor)
        else:
            cross = Cross(constant=twin.yz_coherence)
        rng = stream(twin.name, seed, letter)
        position[0, axis], position[1, axis] = draw_pair(
            first, second, cross, n, twin.frame_rate_hz, rng, twin.form, _shared(twin, seed, letter)
        )
        scratch.put_away()
    lines = _lines(twin, stream(twin.slow.take if twin.slow else twin.name, seed, "phases"))
    t = np.arange(n if lines else 0) * tau0
    for line in lines:
        wave = np.sin(2 * np.pi * line["f_0_hz"] * t + line["phase_rad"])
        wave -= wave[0]
        wave *= line["amplitude_mm"]
        position[_place(line["series"])] += wave
    for series, factor in twin.scale.items():
        position[_place(series)] *= factor
    return [{**line, "scale": twin.scale.get(line["series"], 1.0)} for line in lines]


def _shared(twin: Twin, seed: int, letter: str) -> Shared | None:
    """What drives the slow noise of an axis in all twins of its take."""
    if twin.slow is None:
        return None
    return Shared(stream(twin.slow.take, seed, f"{letter} slow"), twin.slow.below_hz)


def _place(series: str) -> tuple[int, int]:
    return int(series[1]) - 1, AXES.index(series[0])


def _lines(twin: Twin, rng: np.random.Generator) -> list[_Line]:
    """Sinusoids of the coordinates, each with a random phase; L's goes half into x1 and half, with
    the opposite sign, into x2."""
    found: list[_Line] = []
    for series in (*COORDINATES, "L"):
        phase = float(rng.uniform(0, 2 * np.pi))  # drawn for all, so that phases do not shift
        for line in twin.models[series].lines if series in twin.models else ():
            if series != "L":
                places = [(series, 1.0)]
            elif twin.distance_line == "split":
                places = [("x1", 0.5), ("x2", -0.5)]
            else:
                places = []
            height = line.recorded(twin.frame_rate_hz, twin.form)
            found += [
                {
                    "of": series,
                    "series": s,
                    "amplitude_mm": share * height,
                    "f_0_hz": line.f_0,
                    "phase_rad": phase,
                }
                for s, share in places
            ]
    return found


def _origin(twin: Twin, seed: int, n: int) -> Row:
    """What the recording was made from."""
    models = {s: m.scaled(twin.scale.get(s, 1.0)) for s, m in twin.models.items()}
    notes = list(twin.notes)
    bands = clipped_bands(twin.models, twin.frame_rate_hz, n, twin.form)
    if bands:
        text = ", ".join(f"{low:.3g} to {high:.3g} Hz" for low, high in bands)
        notes.append(f"L: contradicts x1 and x2 at {text}; there x1 and x2 are used and L differs")
    if "L" in models and (twin.coherence_factor != 1 or {"x1", "x2"} & set(twin.scale)):
        del models["L"]
        notes.append("L: not a separate model; it follows from x1, x2, their coherence and scale")
    return {
        "twin": twin.name,
        "source": twin.source,
        "seed": seed,
        "form": twin.form,
        "frame_rate_hz": twin.frame_rate_hz,
        "n_frames": n,
        "labels": list(twin.labels),
        "start_mm": [list(point) for point in twin.start_mm],
        "coefficients": {series: model.coefficients() for series, model in models.items()},
        "scale": dict(twin.scale),
        "coherence_factor": twin.coherence_factor,
        "yz_coherence": twin.yz_coherence,
        "slow": asdict(twin.slow) if twin.slow else None,
        "distance_line": twin.distance_line,
        "drift_mm_per_h": {label: list(v) for label, v in twin.drift_mm_per_h.items()},
        "resolution_mm": twin.resolution_mm,
        "clipped_bands_hz": bands,
        "notes": notes,
    }


def _add_crump(position: np.ndarray, twin: Twin, seed: int) -> Row | None:
    crump, rate = twin.crump, twin.frame_rate_hz
    if crump is None:
        return None
    rng = stream(twin.name, seed, "crump")
    weights = rng.uniform(0.5, 1.0, (2, 3)) * rng.choice([-1.0, 1.0], (2, 3))
    start_s = crump.start_s(position.shape[2] / rate)
    first = int(np.ceil(start_s * rate))
    last = min(position.shape[2], first + int(SWINGS * crump.decay_s * rate) + 1)
    t = np.arange(first, max(first, last)) / rate - start_s
    swing = np.exp(-t / crump.decay_s) * np.sin(2 * np.pi * crump.frequency_hz * t)
    swing *= crump.amplitude_mm
    position[:, :, first:last] += weights[:, :, None] * swing
    return asdict(crump) | {"time_s": start_s, "weights": weights.tolist(), "frames": t.size}


def _add_outliers(position: np.ndarray, twin: Twin, seed: int) -> dict[str, Sequence[float | str]]:
    outliers, n = twin.outliers, position.shape[2]
    found: dict[str, Sequence[float | str]] = {
        "frame": [],
        "marker": [],
        "axis": [],
        "amplitude_mm": [],
    }
    if outliers is None:
        return found
    rng = stream(twin.name, seed, "outliers")
    expected = outliers.per_hour * n / (3600 * twin.frame_rate_hz)
    count = min(n, int(rng.poisson(expected)))
    frame = np.sort(rng.choice(n, count, replace=False))
    marker, axis = rng.integers(0, 2, count), rng.integers(0, 3, count)
    if outliers.distribution == "normal":
        amplitude = rng.normal(0.0, outliers.amplitude_mm, count)
    else:
        amplitude = rng.exponential(outliers.amplitude_mm, count) * rng.choice([-1.0, 1.0], count)
    position[marker, axis, frame] += amplitude
    found["frame"] = frame.tolist()
    found["marker"] = [twin.labels[i] for i in marker]
    found["axis"] = [AXES[i] for i in axis]
    found["amplitude_mm"] = amplitude.tolist()
    return found


def _cut_gaps(position: np.ndarray, twin: Twin, seed: int) -> dict[str, list[int | str]]:
    gaps, n, rate = twin.gaps, position.shape[2], twin.frame_rate_hz
    found: dict[str, list[int | str]] = {"marker": [], "first_frame": [], "frames": []}
    if gaps is None:
        return found
    rng = stream(twin.name, seed, "gaps")
    for marker, label in enumerate(twin.labels):
        count = int(rng.poisson(gaps.per_hour * n / (3600 * rate)))
        starts = np.sort(rng.integers(0, n, count))
        lengths = np.maximum(1, np.round(rng.exponential(gaps.mean_s * rate, count))).astype(int)
        for start, length in zip(starts.tolist(), lengths.tolist(), strict=True):
            position[marker, :, start : start + length] = np.nan
            found["marker"].append(label)
            found["first_frame"].append(start)
            found["frames"].append(min(length, n - start))
    return found
