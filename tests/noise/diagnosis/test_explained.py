"""Whole recordings in which one disturbance looks like several: only the one is a finding."""

import math
from collections.abc import Callable
from dataclasses import fields

import numpy as np
import pytest
from scipy import signal

from mocap_metrology.noise.diagnosis.events import Event
from mocap_metrology.noise.diagnosis.export import LowPass, bands, low_passes
from mocap_metrology.noise.diagnosis.findings import Finding, findings_of
from mocap_metrology.noise.diagnosis.outliers import Tails
from mocap_metrology.noise.diagnosis.periodic import SpectralLine
from mocap_metrology.noise.diagnosis.recording import diagnose
from mocap_metrology.noise.diagnosis.records import Diagnosis, Recording, explained
from mocap_metrology.noise.diagnosis.resonance import Resonance, resonance
from mocap_metrology.noise.diagnosis.signatures import Wander
from mocap_metrology.noise.fit.spectral.line import Line
from mocap_metrology.noise.fit.spectral.welch import welch
from mocap_metrology.noise.motion.movement import Movement

RATE, N = 50.0, 30_000
T = np.arange(N) / RATE
NAMES = ["x1", "y1", "z1"]
NOTHING = {x.name: {} if "dict" in str(x.type) else [] for x in fields(Diagnosis)}


def oscillator(f_0: float, damping: float, rms: float, seed: int) -> np.ndarray:
    """Driven by white noise; the bilinear transform, warped so that it leaves f_0."""
    w_0 = 2 * RATE * np.tan(np.pi * f_0 / RATE)
    b, a = signal.bilinear([w_0**2], [1, 2 * damping * w_0, w_0**2], RATE)
    shaken = signal.lfilter(b, a, np.random.default_rng(seed).standard_normal(N))
    return np.asarray(rms * shaken / shaken.std())


def said_of(x: np.ndarray) -> list[Finding]:
    """Of (3, N) positions of one marker."""
    stored = dict(zip(NAMES, x.astype(np.float32).astype(float), strict=True))
    recording = Recording(stored, ["A"], [], RATE, 4e-6, "float32")
    densities = {name: spectrum(values) for name, values in stored.items()}
    size = densities["x1"]["f_hz"].size
    psd = {k: np.concatenate([one[k] for one in densities.values()]) for k in densities["x1"]}
    psd["series"] = np.repeat(NAMES, size)
    return findings_of(recording, diagnose(recording, [], psd), [])


def fan(x: np.ndarray) -> None:
    x[:3] += 0.03 * (T // 100 % 2 == 0) * np.sin(2 * np.pi * 17.3 * T)


def positions(x: np.ndarray) -> None:
    x[1] += 0.045 * np.array([0, 1, 2, 0, 2, 1, 0, 2, 0, 1, 2, 0])[(T // 50).astype(int)]


def doors(x: np.ndarray) -> None:
    x[:3] += 0.2 * np.exp(-(T % 30) / 0.8) * np.sin(2 * np.pi * 4 * (T % 30))


def switch(x: np.ndarray) -> None:
    x[0] += 0.04 * (T // 20 % 2)


def shaker(x: np.ndarray) -> None:
    """Which folds to a cycle of 10 s in means of a second."""
    x[:3] += 0.3 * np.sin(2 * np.pi * 7.1 * T)


def mount(x: np.ndarray) -> None:
    x += np.array([[1.0], [0.5], [0.2]]) * oscillator(6.0, 0.03, 0.03, 7)


def spring(x: np.ndarray) -> None:
    """So little damped that its peak may be taken for a line whose frequency wanders."""
    x[0] += oscillator(6.0, 0.009, 0.04, 7)


def lobes(x: np.ndarray) -> None:
    """A filter whose stop band is bands, and whose ends are loud."""
    x[:] = signal.savgol_filter(x, 51, 3)


def steep(x: np.ndarray) -> None:
    x[:] = signal.sosfiltfilt(signal.butter(2, 1.5, fs=RATE, output="sos"), x)
    x[:, 0] += 0.05


def pendulum(x: np.ndarray) -> None:
    """Which comes to rest: the noise beside it stays as it is."""
    x[:2] += 0.1 * np.sin(2 * np.pi * 0.45 * T) * np.exp(-T / 200)


def louder(x: np.ndarray) -> None:
    x *= 1 + 2 * T / T[-1]


def held(x: np.ndarray) -> None:
    """Every fifth frame, as of a slower camera, which have few fast changes."""
    x[:] = np.repeat(x[:, ::5], 5, axis=1)


@pytest.mark.parametrize(
    ("disturb", "code", "value"),
    [(fan, "line", 17.3), (positions, "levels", 0.09), (doors, "recurring", 30.0),
     (switch, "two_levels", 0.04), (mount, "resonance", 6.0), (shaker, "line", 7.1),
     (spring, "resonance", 6.0), (lobes, "low_pass", 1.27), (steep, "low_pass", 1.5),
     (held, "repeated", 0.8), (pendulum, "line", 0.45), (louder, "level_changes", 2.0)],
)  # fmt: skip
def test_one_disturbance_is_one_kind_of_finding(
    disturb: Callable[[np.ndarray], None], code: str, value: float
) -> None:
    """But for doors, each of which is an event, and whose shaking may be a line."""
    x = 0.02 * np.random.default_rng(3).standard_normal((3, N))
    disturb(x)
    found = said_of(x)
    beside = {"line", "event"} if disturb is doors else set()
    assert {one.code for one in found} - beside == {code}
    values = [abs(one.value) for one in found if one.code == code]
    assert values == pytest.approx([value] * len(values), rel=0.05)


@pytest.mark.parametrize(("low_hz", "sweep_s"), [(1.0, 600.0), (2.0, 150.0)])
def test_a_sweep_is_no_finding(low_hz: float, sweep_s: float) -> None:
    """Up to 24 Hz, and down again: windows in which it is slow have more of slow noise alone."""
    x = 0.02 * np.random.default_rng(4).standard_normal((3, N))
    at_hz = low_hz + (24 - low_hz) * np.abs((T / sweep_s + 1) % 2 - 1)
    x += 0.03 * np.sin(2 * np.pi * np.cumsum(at_hz) / RATE)
    assert not said_of(x)


@pytest.mark.parametrize(
    ("kinds", "possible", "size_mm", "moves"),
    [((), ("steps", "drift"), 0.08, False), ((), ("steps", "drift"), 3.0, True),
     ((), ("warm_up",), 0.08, True), (("step",), ("step",), 0.08, True)],
)  # fmt: skip
def test_what_may_be_switches_of_cameras_is_no_movement(
    kinds: tuple[str, ...], possible: tuple[str, ...], size_mm: float, moves: bool
) -> None:
    """Positions between which a marker goes to and fro, unless they are as far apart as no cameras
    of one facility put them."""
    jump = {"x1": Movement(size_mm, size_mm - 0.01, size_mm + 0.01, 90.0)}
    wanders = {"x1": Wander(kinds, "", possible, size_mm, 0.01, size_mm)}
    found = explained(Diagnosis(**NOTHING | {"movements": jump, "wanders": wanders}), 600.0, 2.0)
    assert found.movements["x1"].moves is moves


def test_a_cycle_at_a_multiple_of_recurring_bursts_is_theirs() -> None:
    for period_s, stands in ((10.0, False), (30.1, False), (20.0, True)):
        cycle = Wander(("cycle",), "", ("cycle",), 0.1, 0.01, 0.1, at_s=(period_s,))
        found = Diagnosis(**NOTHING | {"wanders": {"x1": cycle}, "recurring": {"x1": 30.0}})
        assert bool(explained(found, 600.0).wanders) is stands


def test_a_switch_back_at_once_is_no_event() -> None:
    """Of a position that a marker stays at for less than is seen as a level."""
    wanders = {"x1": Wander(("levels",), "", ("levels",), 0.0, 0.01, 0.09, 0.09)}
    for size_mm, shift_mm, stands in ((0.117, -0.089, False), (0.12, 0.0, False), (0.3, 0.3, True)):
        event = Event(180.0, 2.0, "burst", ("x1",), "x1", size_mm, shift_mm, 0.01, 9.0, 0.1)
        found = Diagnosis(**NOTHING | {"wanders": wanders, "events": [event]})
        assert bool(explained(found, 600.0).events) is stands


def test_loud_frames_of_heavy_tails_and_ends_of_a_filter_are_no_event() -> None:
    """In which nothing moved; elsewhere they are one. A filter of 0.5 Hz has ends of 2 s."""
    tails = [Tails("x1", 9.0, 8.0, 10.0)]
    for moved, series, stands in ((False, "x1", False), (True, "x1", True), (False, "y1", True)):
        event = Event(90.0, 1.0, "burst", (series,), series, 0.3, 0.0, 0.01, 9.0, 0.1, moved=moved)
        found = Diagnosis(**NOTHING | {"tails": tails, "events": [event]})
        assert bool(explained(found, 600.0).events) is stands
    for at_s, stands in ((0.9, False), (1.1, True), (597.9, True), (598.1, False)):
        event = Event(at_s, 1.0, "burst", ("x1",), "x1", 0.3, 0.0, 0.01, 9.0, 0.1)
        found = Diagnosis(**NOTHING | {"low_pass": [LowPass("x1", 0.5, 0.1)], "events": [event]})
        assert bool(explained(found, 600.0).events) is stands


@pytest.mark.parametrize(
    ("series", "size", "width", "code"),
    [
        *(("x1", 0.008, 0.0, "resonance"), ("x1", 0.03, 0.0, "line"), ("y1", 0.03, 0.0, "line")),
        ("y1", 0.001, 0.004, "resonance"),
    ],
)
def test_a_weak_line_in_a_resonance_is_a_part_of_it(
    series: str, size: float, width: float, code: str
) -> None:
    """A band of another series, too; and a strong one of another series is the peak."""
    line = Line(size, 6.1, 0.0, 1.0, 99.0, width, band_hz=(6.0, 6.2) if width else None)
    line = SpectralLine(series, line, *[math.nan] * 3, None, None, *[math.nan] * 2, *[math.nan] * 3)
    one = Resonance("x1", 6.0, 0.03, 0.02)
    found = explained(Diagnosis(**NOTHING | {"lines": [line], "resonances": [one]}), 600.0)
    assert bool(found.lines) is (code == "line") and bool(found.resonances) is (code != "line")


def test_what_oscillates_is_no_low_pass() -> None:
    """Noise of an autoregression whose density rises three times before it falls; a Butterworth
    filter has none of that."""
    for sos, named in (([[1, 0, 0, 1, -1.1, 0.6]], 0), (signal.butter(2, 0.4, output="sos"), 4)):
        x = signal.sosfilt(sos, np.random.default_rng(2).standard_normal((4, N)))
        found = {f"x{k}": bands(row, RATE) for k, row in enumerate(x)}
        assert len(low_passes(found, RATE, 0.0)) == named


def test_levels_of_noise_that_steps_hide_are_not_stated() -> None:
    """A marker that moves over five steps of the file is noisy between two of them alone."""
    x = 0.01 * np.random.default_rng(3).standard_normal((3, N)) + 0.3 * np.exp(-T / 90)
    stored = dict(zip(NAMES, 0.1 * np.round(x / 0.1), strict=True))
    recording = Recording(stored, ["A"], [], RATE, 0.1, "text")
    codes = {one.code for one in findings_of(recording, diagnose(recording, [], None), [])}
    assert "resolution_limited" in codes and "level_changes" not in codes


@pytest.mark.parametrize("beside", ["white", "blue", "cycle"])
@pytest.mark.parametrize(
    ("f_0", "damping", "rms"), [(2.5, 0.08, 0.02), (6.0, 0.03, 0.01), (11.5, 0.01, 0.03)]
)
def test_frequency_damping_and_size_of_a_resonance(
    f_0: float, damping: float, rms: float, beside: str
) -> None:
    """Within 3, 25 and 10 %, beside noise of the same size, white or the difference of white, and
    beside a cycle of a minute."""
    noise = 0.02 * np.random.default_rng(6).standard_normal(N + 1)
    values = oscillator(f_0, damping, rms, 5)
    values += np.diff(noise) if beside == "blue" else noise[1:]
    values += 0.06 * np.sin(T / 11.7) if beside == "cycle" else 0.0
    found = resonance("x1", values, RATE, spectrum(values))
    assert found is not None
    assert found.f_hz == pytest.approx(f_0, rel=0.03)
    assert found.damping == pytest.approx(damping, rel=0.25)
    assert found.rms_mm == pytest.approx(rms, rel=0.1)


def correlated(times: int) -> np.ndarray:
    drive = np.random.default_rng(11).standard_normal(N)
    for _ in range(times):
        drive = signal.lfilter([1], [1, -0.9], drive)
    return 0.05 * drive / drive.std()


def hits() -> np.ndarray:
    times = np.cumsum(np.random.default_rng(12).exponential(40, 20))
    since = np.maximum(T - times[:, None], 0)
    ringing = (since > 0) * np.exp(-since / 0.3) * np.sin(16 * np.pi * since)
    return 0.15 * ringing.sum(axis=0)


def passing() -> np.ndarray:
    """Steps at 1.9 a second of those who pass by, every 20 s."""
    times = np.cumsum(np.random.default_rng(13).exponential(20, 80))
    envelope = np.exp(-(((T - times[:, None]) / 2.5) ** 2)).sum(axis=0)
    return 0.02 * envelope * np.sin(2 * np.pi * 1.9 * T)


OTHER: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "white": lambda x: x,
    "walk": lambda x: x + np.cumsum(0.002 * np.random.default_rng(9).standard_normal(N)),
    "line": lambda x: x + 0.03 * np.sin(2 * np.pi * 12 * T),
    "burst": lambda x: x + oscillator(6.0, 0.03, 0.1, 10) * ((T > 200) & (T < 260)),
    "correlated": lambda x: x + correlated(1),
    "falling": lambda x: x + correlated(2),
    "hits": lambda x: x + hits(),
    "passing": lambda x: x + passing(),
    "sweep": lambda x: x + 0.03 * np.sin(2 * np.pi * (2 * T + 9 * T**2 / T[-1])),
    "sweep in noise": lambda x: x + 0.03 * np.sin(2 * np.pi * (8 * T + 2 * T**2 / T[-1])),
    "lobes": lambda x: signal.savgol_filter(x, 21, 3),
    "notch": lambda x: signal.filtfilt(*signal.iirnotch(RATE / 4, 5, fs=RATE), x),
}


@pytest.mark.parametrize("kind", OTHER)
def test_other_spectra_are_no_resonance(kind: str) -> None:
    """A line that is known, an oscillation that goes on for a minute only, Gauss-Markov noise or
    its filtered form (f^-4), hits that ring, steps of people, a frequency that sweeps, filters."""
    values = OTHER[kind](0.02 * np.random.default_rng(8).standard_normal(N))
    assert resonance("x1", values, RATE, spectrum(values), [12.0]) is None


def spectrum(values: np.ndarray) -> dict[str, np.ndarray]:
    density = welch(values, RATE)
    n = np.full(density.f_hz.size, density.n_segments)
    return {"f_hz": density.f_hz, "psd_mm2_hz": density.psd, "n_segments": n}
