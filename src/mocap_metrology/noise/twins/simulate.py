"""Simulated recordings ("twins") of two markers, from noise coefficients.

    twin = Twin("T40-10", 1, **vars(of_published("T40", 10)))
    recording = simulate(twin)                       # nine hours
    recording.position_mm                            # (2 markers, 3 axes, n frames)

The Allan variance of every coordinate is its model's at every tau (`synthesis` says how), in the
twin's `form`; that of the distance too, wherever the models of x1, x2 and L do not contradict each
other.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from datetime import date
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.large import Scratch
from mocap_metrology.common.types import Row
from mocap_metrology.noise.model.synthesis import Cross, Shared, clipped_bands, draw_pair
from mocap_metrology.noise.twins.twin import COORDINATES, Twin

AXES = ("x", "y", "z")
SWINGS = 20  # a crump is followed for so many decay times: exp(-20) = 2e-9
LEAST_FRAMES = 16


@dataclass(frozen=True)
class SimulatedRecording:
    """`position_mm` (2 markers, 3 axes, n frames), NaN in gaps; `truth`, ready for JSON, states
    what went in: coefficients, clipped bands, outliers, crump, gaps, notes."""

    frame_rate_hz: float
    position_mm: np.ndarray
    truth: Row


def stream(twin_name: str, seed: int, purpose: str) -> np.random.Generator:
    """PCG64 of SeedSequence([seed, crc32(twin name), crc32(purpose)]): every twin and, within it,
    every purpose (`x`, `y`, `z`, `phases`, `outliers`, `crump`, `gaps`) has a stream of its own,
    so nothing depends on the order of drawing, and adding outliers leaves the noise as it was."""
    words = [seed, crc32(twin_name.encode()), crc32(purpose.encode())]
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(words)))


def frames_of(name: str, duration_s: float, frame_rate_hz: float) -> int:
    """Number of frames of a twin's recording; refused where they are too few."""
    n = round(duration_s * frame_rate_hz)
    if n < LEAST_FRAMES:
        raise Refusal(
            f"twin {name}: duration {duration_s:g} s, expected {LEAST_FRAMES} frames at least"
        )
    return n


def truth_of(twin: Any, n: int, source: str, **more: object) -> Row:
    """What any twin's recording of n frames was made from."""
    return {
        **{"twin": twin.name, "source": source, "seed": twin.seed, "form": twin.form},
        **{"frame_rate_hz": twin.frame_rate_hz, "n_frames": n, "labels": list(twin.labels)},
        **more,
    }


def simulate(
    twin: Twin,
    duration_s: float | None = None,
    folder: str | Path | None = None,
) -> SimulatedRecording:
    """Simulate `twin` for `duration_s` (default: its own).

    Noise starts at 0 in the first frame, so the recording starts at `twin.start_mm`; its means
    differ from that by what the noise does. Same twin and duration: same bytes (on one
    build of numpy and scipy). folder: where a large recording waits while it is made. Raises
    `Refusal` for less than 16 frames.
    """
    duration = twin.duration_s if duration_s is None else duration_s
    n = frames_of(twin.name, duration, twin.frame_rate_hz)
    of_row, twin = twin.name, on_its_day(twin)
    scratch = Scratch((2, 3, n), folder)
    position = scratch.values
    lines = _add_noise(scratch, twin)
    position += np.asarray(twin.start_mm)[:, :, None]
    hours = np.arange(n) / (3600 * twin.frame_rate_hz)
    for label, velocity in twin.drift_mm_per_h.items():
        for axis, v in enumerate(velocity):
            position[twin.labels.index(label), axis] += v * hours
    truth = _origin(twin, n) | {"twin": of_row, "sinusoids": lines}
    truth["crump"] = _add_crump(position, twin)
    truth["outliers"] = _add_outliers(position, twin)
    if twin.resolution_mm:
        for coordinate in position.reshape(-1, n):
            np.round(coordinate / twin.resolution_mm, out=coordinate)
            coordinate *= twin.resolution_mm
    truth["gaps"] = _cut_gaps(position, twin)
    return SimulatedRecording(twin.frame_rate_hz, position, truth)


def on_its_day(twin: Twin) -> Twin:
    """A twin of a facility as it is on its date: place, distance and noise by the scatter from day
    to day and the changes so far, and streams of random numbers of this date."""
    if twin.days is None:
        return twin
    days, name = twin.days, f"{twin.name} {twin.date}"
    *place, length, jitter = stream(name, twin.seed, "day").standard_normal(5).tolist()
    shift, factor = days.place_mm * np.array(place), float(np.exp(days.jitter * jitter))
    length *= days.length_mm
    for change in (one for one in days.changes if one.since <= twin.date):
        past = date.fromisoformat(twin.date[:10]) - date.fromisoformat(change.since)
        shift = shift + np.array(change.place_mm)
        length += change.length_mm + change.length_mm_per_day * past.days
        factor *= change.jitter
    first, second = np.array(twin.start_mm)
    along = (second - first) / np.linalg.norm(second - first)
    half, scale = length / 2 * along, {c: factor * twin.scale.get(c, 1.0) for c in COORDINATES}
    start: tuple[Any, Any] = tuple(first + shift - half), tuple(second + shift + half)
    return replace(twin, name=name, start_mm=start, scale=scale)


def _add_noise(scratch: Scratch, twin: Twin) -> list[Row]:
    """Fill the scratch with noise that starts at 0; return the sinusoids that went in."""
    position, rate, slow = scratch.values, twin.frame_rate_hz, twin.slow
    n, tau0, seed = position.shape[2], 1 / rate, twin.seed
    for axis, letter in enumerate(AXES):
        first, second = (twin.models[f"{letter}{marker}"] for marker in (1, 2))
        cross = Cross(constant=twin.yz_coherence)
        if letter == "x":
            cross = Cross(twin.models.get("L"), twin.coherence_factor)
        # What drives the slow noise of an axis in all twins of its take
        shared = Shared(stream(slow.take, seed, f"{letter} slow"), slow.below_hz) if slow else None
        rng = stream(twin.name, seed, letter)
        position[:2, axis] = draw_pair(first, second, cross, n, rate, rng, twin.form, shared)
        scratch.put_away()
    lines = _lines(twin, stream(slow.take if slow else twin.name, seed, "phases"))
    t = np.arange(n if lines else 0) * tau0
    for _, series, amplitude, f_0, phase in lines:
        wave = np.sin(2 * np.pi * f_0 * t + phase)
        wave -= wave[0]
        wave *= amplitude
        position[_place(series)] += wave
    for series, factor in twin.scale.items():
        position[_place(series)] *= factor
    names = ("of", "series", "amplitude_mm", "f_0_hz", "phase_rad")
    scales = [twin.scale.get(line[1], 1.0) for line in lines]
    return [
        {**dict(zip(names, line, strict=True)), "scale": scale}
        for line, scale in zip(lines, scales, strict=True)
    ]


def _place(series: str) -> tuple[int, int]:
    return int(series[1]) - 1, AXES.index(series[0])


def _lines(twin: Twin, rng: np.random.Generator) -> list[tuple[str, str, float, float, float]]:
    """Sinusoids of the coordinates: series of the model, coordinate, amplitude, frequency, phase.
    Each has a random phase; L's goes half into x1 and half, with the opposite sign, into x2."""
    lines = []
    for series in (*COORDINATES, "L"):
        phase = float(rng.uniform(0, 2 * np.pi))  # drawn for all, so that phases do not shift
        places = {series: 1.0}
        if series == "L":
            places = {"x1": 0.5, "x2": -0.5} if twin.distance_line == "split" else {}
        for line in twin.models[series].lines if series in twin.models else ():
            height = line.recorded(twin.frame_rate_hz, twin.form)
            lines += [(series, s, share * height, line.f_0, phase) for s, share in places.items()]
    return lines


def _origin(twin: Twin, n: int) -> Row:
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
    return truth_of(
        twin,
        n,
        twin.source,
        start_mm=[list(point) for point in twin.start_mm],
        coefficients={series: model.coefficients() for series, model in models.items()},
        scale=dict(twin.scale),
        coherence_factor=twin.coherence_factor,
        yz_coherence=twin.yz_coherence,
        slow=asdict(twin.slow) if twin.slow else None,
        distance_line=twin.distance_line,
        drift_mm_per_h={label: list(v) for label, v in twin.drift_mm_per_h.items()},
        resolution_mm=twin.resolution_mm,
        clipped_bands_hz=bands,
        notes=notes,
    )


def _add_crump(position: np.ndarray, twin: Twin) -> Row | None:
    crump, rate = twin.crump, twin.frame_rate_hz
    if crump is None:
        return None
    rng = stream(twin.name, twin.seed, "crump")
    weights = rng.uniform(0.5, 1.0, (2, 3)) * rng.choice([-1.0, 1.0], (2, 3))
    start_s = crump.start_s(position.shape[2] / rate)
    first = int(np.ceil(start_s * rate))
    last = min(position.shape[2], first + int(SWINGS * crump.decay_s * rate) + 1)
    t = np.arange(first, max(first, last)) / rate - start_s
    swing = np.exp(-t / crump.decay_s) * np.sin(2 * np.pi * crump.frequency_hz * t)
    swing *= crump.amplitude_mm
    position[:, :, first:last] += weights[:, :, None] * swing
    return asdict(crump) | {"time_s": start_s, "weights": weights.tolist(), "frames": t.size}


def _add_outliers(position: np.ndarray, twin: Twin) -> Row:
    outliers, n = twin.outliers, position.shape[2]
    if outliers is None:
        return {"frame": [], "marker": [], "axis": [], "amplitude_mm": []}
    rng = stream(twin.name, twin.seed, "outliers")
    expected = outliers.per_hour * n / (3600 * twin.frame_rate_hz)
    count = min(n, int(rng.poisson(expected)))
    frame = np.sort(rng.choice(n, count, replace=False))
    marker, axis = rng.integers(0, 2, count), rng.integers(0, 3, count)
    if outliers.distribution == "normal":
        amplitude = rng.normal(0.0, outliers.amplitude_mm, count)
    else:
        amplitude = rng.exponential(outliers.amplitude_mm, count) * rng.choice([-1.0, 1.0], count)
    position[marker, axis, frame] += amplitude
    return {
        "frame": frame.tolist(),
        "marker": [twin.labels[i] for i in marker],
        "axis": [AXES[i] for i in axis],
        "amplitude_mm": amplitude.tolist(),
    }


def _cut_gaps(position: np.ndarray, twin: Twin) -> dict[str, list[int | str]]:
    gaps, n, rate = twin.gaps, position.shape[2], twin.frame_rate_hz
    cut: dict[str, list[int | str]] = {"marker": [], "first_frame": [], "frames": []}
    if gaps is None:
        return cut
    rng = stream(twin.name, twin.seed, "gaps")
    for marker, label in enumerate(twin.labels):
        count = int(rng.poisson(gaps.per_hour * n / (3600 * rate)))
        starts = np.sort(rng.integers(0, n, count))
        lengths = np.maximum(1, np.round(rng.exponential(gaps.mean_s * rate, count))).astype(int)
        for start, length in zip(starts.tolist(), lengths.tolist(), strict=True):
            position[marker, :, start : start + length] = np.nan
            cut["marker"].append(label)
            cut["first_frame"].append(start)
            cut["frames"].append(min(length, n - start))
    return cut
