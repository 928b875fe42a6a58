"""A simulated bar that is carried through a volume whose length errors are known.

e = bias + surface + pass + Gauss-Markov + white: the surface is a quadratic polynomial of the place
in the box of the path, drawn by the seed of the room, so passes with one `room_seed` share it. The
error is along the bar, at its second marker; the path is a Lissajous figure with a phase of its own
in every pass.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass as entry

from mocap_metrology.common.entries import ENTRY, MADE, NonNegative, Number, Positive, Whole, one_of
from mocap_metrology.noise.model.components import Form
from mocap_metrology.noise.twins.simulate import SimulatedRecording, frames_of, stream, truth_of
from mocap_metrology.noise.twins.twin import Labels, Place

Along = Literal["x", "y", "z", "turning"]
RATIOS = (1.0, 1.618, 2.414)  # of the frequencies of the path: it never closes
WOBBLE_DEG = 5.0
TURN_S = 20.0


@entry(frozen=True, config=ENTRY)
class BarMotion:
    """How the bar is carried."""

    extent_mm: Place = (2000.0, 1200.0, 600.0)
    """Extents of the path along x, y and z."""
    speed_mm_s: Positive = 400.0
    """Mean speed."""
    along: Annotated[Along, one_of(("x", "y", "z", "turning"), "x, y, z or turning")] = "x"
    """Axis that the bar points along, wobbling by 5 degrees, or `turning`."""


@entry(frozen=True, config=ENTRY)
class BarErrors:
    """A bar and what its measured length is wrong by, standard deviations in mm."""

    length: Positive
    """True length, as in column `length_mm`."""
    surface: NonNegative = 0.0
    """Bending of the volume: of a quadratic surface along the path."""
    pass_mm: NonNegative = 0.0
    """From pass to pass."""
    correlation_s: Positive = 0.3
    """Correlation time of what changes within a pass."""
    path: BarMotion = Field(default_factory=BarMotion)
    """The path."""
    rest: NonNegative = 0.5
    """Of what changes within a pass, by this correlation time."""
    frame: NonNegative = 0.1
    """White noise of the length, frame by frame."""
    bias: Annotated[float, Number(-1000, 1000)] = 0.0
    """Error of the mean."""
    room_seed: Annotated[int, Whole()] = 1
    """Seed of the surface, the same in all passes of one room."""


@entry(frozen=True, config=ENTRY)
class BarTwin:
    """A twin of a bar that is carried through the volume: rows of a group are passes."""

    form: ClassVar[Form] = "sampled"

    name: Annotated[str, MADE]
    bar: BarErrors
    """The bar."""
    seed: Annotated[int, Whole()]
    """The same seed gives the same pass."""
    duration_s: Positive = 60.0
    """Length; at most that of config.yaml."""
    frame_rate_hz: Positive = 120.0
    """Frames per second."""
    labels: Labels = ("Wand1", "Wand2")
    """Names of the two markers in the file."""


def simulate_bar(twin: BarTwin) -> SimulatedRecording:
    """A pass. Same twin: same bytes."""
    bar, rate = twin.bar, twin.frame_rate_hz
    n = frames_of(twin.name, twin.duration_s, rate)
    draw = stream("bar", twin.seed, "path")
    relative, middle = _path(bar.path, np.arange(n) / rate, draw.uniform(0, 2 * math.pi, 3))
    direction = _directions(bar.path.along, np.arange(n) / rate, draw.uniform(0, 2 * math.pi, 3))
    drawn = stream("bar", twin.seed, "errors")
    offset = bar.pass_mm * float(drawn.standard_normal())
    error = bar.bias + offset + bar.surface * unit_surface(bar.room_seed, relative)
    error += bar.rest * gauss_markov(drawn, n, bar.correlation_s * rate)
    half = direction * (bar.length + error) / 2
    position = np.stack([middle - half, middle + half])
    position += bar.frame / math.sqrt(2) * drawn.standard_normal(position.shape)
    truth = truth_of(
        twin,
        n,
        "simulated bar that is carried through a volume",
        coefficients={},
        length_mm=bar.length,
        bias_mm=bar.bias,
        pass_offset_mm=offset,
        surface_mm=bar.surface,
        pass_mm=bar.pass_mm,
        rest_mm=bar.rest,
        correlation_s=bar.correlation_s,
        frame_mm=bar.frame,
        notes=["the error of the length is along the bar, half of it at either marker"],
    )
    return SimulatedRecording(rate, position, truth)


def _path(way: BarMotion, time_s: np.ndarray, phases: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(3, n) place in the box, -1 to 1, and in mm: a Lissajous figure whose mean speed, over all
    phases, is the root of the mean squares of its axes'."""
    half = np.asarray(way.extent_mm)[:, None] / 2
    ratios = np.asarray(RATIOS)[:, None]
    rms = math.sqrt(float(((half * ratios) ** 2).sum()) / 2)
    relative = np.sin(ratios * way.speed_mm_s / max(rms, 1e-9) * time_s + phases[:, None])
    return relative, half * relative + np.array([[0.0], [0.0], [1000.0]])


def _directions(along: Along, time_s: np.ndarray, phases: np.ndarray) -> np.ndarray:
    """(3, n) of unit length."""
    turn = 2 * math.pi / TURN_S * np.asarray(RATIOS)[:, None] * time_s + phases[:, None]
    wave = np.sin(turn)
    if along != "turning":
        wave *= math.radians(WOBBLE_DEG)
        wave["xyz".index(along)] = 1.0
    return np.asarray(wave / np.linalg.norm(wave, axis=0))


def unit_surface(room_seed: int, relative: np.ndarray) -> np.ndarray:
    """(n,) a quadratic polynomial at places (3, n) of a box from -1 to 1, whose standard deviation
    over the path is 1: the variances of u, u^2 and u v are 1/2, 1/8 and 1/4 there."""
    first, second = np.triu_indices(3)
    weights = stream("bar", room_seed, "room").standard_normal(9)
    variances = np.array(
        [0.5] * 3 + [0.125 if a == b else 0.25 for a, b in zip(first, second, strict=True)]
    )
    terms = np.concatenate(
        [relative, relative[first] * relative[second] - (first == second)[:, None] / 2]
    )
    return np.asarray(weights @ terms / math.sqrt(float(weights**2 @ variances)))


def gauss_markov(draw: np.random.Generator, n: int, correlation_frames: float) -> np.ndarray:
    """(n,) of variance 1 with the autocorrelation exp(-k / correlation_frames)."""
    from scipy.signal import lfilter

    phi = math.exp(-1 / correlation_frames)
    white = math.sqrt(1 - phi**2) * draw.standard_normal(n)
    white[0] /= math.sqrt(1 - phi**2)
    return np.asarray(lfilter([1.0], [1.0, -phi], white))
