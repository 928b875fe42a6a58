"""Events in simulated recordings whose truth is known, and how often sound ones show any."""

import math

import numpy as np
import pytest
from mocap_workflow.recording_twins import twin_from_mapping
from scipy import signal

from benchmarks.sentences._kinds import gauss_markov
from mocap_metrology.noise.diagnosis.dynamic import (
    _dispersion,
    _windows,
    dynamic_allan,
)
from mocap_metrology.noise.diagnosis.events import Event
from mocap_metrology.noise.diagnosis.outliers import isolated_frames, off_frames, without
from mocap_metrology.noise.diagnosis.recording import search_events
from mocap_metrology.noise.diagnosis.recurring import pulses, recurrence, recurring_bout
from mocap_metrology.noise.diagnosis.sides import WHITE, Sides, blocks
from mocap_metrology.noise.series import all_series
from mocap_metrology.noise.twins.simulate import simulate

RATE = 120.0
NAMES = ("x1", "y1", "z1", "x2", "y2", "z2")
KINDS = (("T40", 10), ("Bonita", 10), ("Vantage", 9))
CRUMP = {"time_s": 220.0, "amplitude_mm": 1.0, "decay_s": 0.8, "frequency_hz": 5.0}
FALSE_ALARM = 0.01


def recorded(kind, seed, duration_s=600.0, **more):
    """Coordinates (6, n) of a twin of the published coefficients, and its truth."""
    published = {"camera_type": kind[0], "n_cameras": kind[1]}
    twin = twin_from_mapping({"published": published, "seed": seed, **more}, f"{kind[0]}-{kind[1]}")
    made = simulate(twin, duration_s)
    return made.position_mm.reshape(6, -1), made.truth


def events_of(position, false_alarm=FALSE_ALARM):
    raw = dict(zip(NAMES, position.astype(np.float32), strict=True))
    off = {k: off_frames(v, 6.0) for k, v in raw.items()}
    spikes = isolated_frames(off, {k: int(k[1]) for k in raw})
    quiet = {k: without(v, spikes[k]) for k, v in raw.items()}
    series = dict(all_series(quiet, [(1, 2)]))
    return search_events(series, [(1, 2)], RATE, 0.0, false_alarm, 300.0)[0]


def loud_after(position, from_s, factor):
    """The same with its noise made `factor` times as large from then on."""
    first = int(from_s * RATE)
    steps = np.diff(position, axis=1)
    steps[:, first:] *= factor
    return np.concatenate([position[:, :1], position[:, :1] + np.cumsum(steps, axis=1)], axis=1)


@pytest.mark.parametrize(("there", "known"), [(4, True), (3, False)])
def test_a_window_has_half_of_its_differences(there: int, known: bool) -> None:
    seen = np.arange(80) % 8 < there
    mean, share = _windows(np.full(80, 2.0), seen, 8)
    assert (share == there / 8).all()
    np.testing.assert_array_equal(mean, np.full(mean.size, 2.0 if known else np.nan))


def test_degrees_of_freedom_of_a_window() -> None:
    """(sum r)^2 / sum r^2 and max r / sum r of the eigenvalues r of its differences: n and 1/n of
    white noise, 2 and 1/2 of a sinusoid; one and all where nothing moves, or nothing is known."""
    rng, n = np.random.default_rng(2), 64
    edf, kappa = _dispersion(rng.standard_normal((4000, n)))
    assert edf == pytest.approx(n, rel=0.03) and kappa == pytest.approx(1 / n, rel=0.25)
    wave = np.sin(2 * np.pi * 5 / n * np.arange(n) + rng.uniform(0, 7, (400, 1)))
    assert _dispersion(wave) == pytest.approx((2, 0.5), rel=1e-6)
    assert _dispersion(np.zeros((9, n))) == _dispersion(np.zeros((0, n))) == (1.0, 1.0)


@pytest.mark.parametrize("kind", KINDS)
def test_sound_recordings_have_no_events(kind):
    """15 of 10 minutes at a false alarm of 1 %."""
    outliers = {"per_hour": 100, "amplitude_mm": 0.5}
    for seed in range(5):
        position, _ = recorded(kind, seed, outliers=outliers)
        assert not events_of(position)


@pytest.mark.parametrize("kind", KINDS)
def test_a_crump_is_found_and_measured(kind):
    outliers = {"per_hour": 100, "amplitude_mm": 0.5}
    for seed in range(2):
        position, truth = recorded(kind, seed, crump=CRUMP, outliers=outliers)
        (event,) = events_of(position)
        t = np.arange(1200) / RATE
        swing = np.exp(-t / CRUMP["decay_s"]) * np.sin(2 * np.pi * CRUMP["frequency_hz"] * t)
        size = np.abs(truth["crump"]["weights"]).max() * np.abs(swing).max()
        assert abs(event.time_s - CRUMP["time_s"]) < 0.1
        assert event.size_mm == pytest.approx(size, rel=0.2)
        assert set(event.series) >= set(NAMES)
        assert event.outcome == "once"
        assert abs(event.shift_mm) < 0.2 * size


def test_noise_that_doubles_after_a_crump_is_said_to():
    for seed in range(2):
        position, _ = recorded(("T40", 10), seed, crump=CRUMP)
        (event,) = events_of(loud_after(position, CRUMP["time_s"] + 5, 2.0))
        assert event.kind == "burst"
        assert event.outcome == "level changed"
        assert all(side.lower < 2.0 < side.upper for side in event.sides)
    crump, change = events_of(loud_after(position, 400.0, 2.0))  # which ends the side of the crump
    assert (crump.outcome, change.outcome, change.of) == ("once", "level changed", 1)


def test_windows_of_the_louder_side_of_a_change_are_no_bursts():
    """Beside a median of both sides some of them would be, by chance; the level is said."""
    for seed in (2, 11):
        rng = np.random.default_rng(seed)
        x = 0.02 * rng.standard_normal((6, 26_400)) * np.where(np.arange(26_400) > 17_160, 2.4, 1)
        x[3] += 500
        (event,) = events_of(x)
        assert (event.kind, event.time_s) == ("level", pytest.approx(143, abs=10))


@pytest.mark.parametrize(
    ("kind", "interval", "of", "outcome", "after", "matters"),
    [
        ("level", (1.09, 1.05, 1.13), 1, "level changed", "changed", False),
        ("level", (1.1, 1.05, 1.15), 1, "level changed", "changed", True),
        ("level", (0.9, 0.86, 0.95), 1, "level changed", "changed", True),
        ("burst", (1.09, 1.05, 1.13), 1, "level changed", "changed", True),
        ("burst", (1.0, 0.9, 1.1), 1, "once", "alike", True),
        ("burst", (1.0, 0.5, 2.0), 2, "repeated", "undecided", True),
        ("burst", None, 1, "unknown", "alike", True),
    ],
)
def test_what_is_left_of_an_event(kind, interval, of, outcome, after, matters) -> None:
    """By the ratio of the noise after it to that before, and its interval."""
    sides = (Sides("x1", 1.0, 1.0, 1.0, 1.0, *interval),) if interval else ()
    event = Event(1.0, 2.0, kind, ("x1",), "x1", 1.0, 0.0, 0.0, 1.0, 1.0, sides, of)
    assert (event.outcome, event.noise_after, event.matters) == (outcome, after, matters)


def test_the_bound_holds_in_the_tail():
    """Share of windows beyond x is at most exp(-x), for white noise at every averaging time."""
    rng = np.random.default_rng(8)
    x = np.concatenate([
        d.x for _ in range(6) for d in dynamic_allan(rng.normal(size=200_000), RATE)
    ])  # fmt: skip
    for level in (2.0, 4.0, 6.0):
        assert np.mean(x > level) <= np.exp(-level)
    assert np.mean(x > 2.0) > 1e-4  # and is not empty


def walk(rng: np.random.Generator, n: int) -> np.ndarray:
    """Stationary once differenced; with gaps."""
    found = np.cumsum(rng.normal(0, 0.004, (6, n)), axis=1)
    found[:3, 5_000:5_400] = np.nan
    found[3:, 40_000:40_090] = np.nan
    return found


def telegraph(rng: np.random.Generator, n: int) -> np.ndarray:
    jumps = (-1.0) ** np.cumsum(rng.random((6, n)) < 1 / RATE, axis=1)
    return 0.05 * (rng.standard_normal((6, n)) + 2 * jumps)


def with_size(size):
    """White noise of a level that changes slowly, by a function of time from 0 to 1."""
    return lambda rng, n: rng.normal(0, 0.05, (6, n)) * size(np.linspace(0, 1, n))


QUIET = {
    "walk": walk,
    "telegraph": telegraph,
    "Student t3": lambda rng, n: 0.05 * rng.standard_t(3, (6, n)) / np.sqrt(3),
    "Student t4": lambda rng, n: 0.05 * rng.standard_t(4, (6, n)) / np.sqrt(2),
    "Laplace": lambda rng, n: 0.05 * rng.laplace(size=(6, n)) / np.sqrt(2),
    "contaminated": lambda rng, n: (
        rng.normal(0, 0.05, (6, n)) * np.where(rng.random((6, n)) < 0.05, 5, 1)
    ),
    "falls by 15 %": with_size(lambda t: 1 - 0.15 * t),
    "falls by half": with_size(lambda t: 1 - 0.5 * t),
    "comes back": with_size(lambda t: 1 + 0.2 * np.sin(2 * np.pi * t)),
    "warms up": with_size(lambda t: 1 + 0.3 * np.exp(-6 * t)),
}


@pytest.mark.parametrize("kind", QUIET)
def test_noise_of_any_kind_and_slow_changes_of_level_are_no_events(kind):
    for seed in range(2):
        assert not events_of(160 + QUIET[kind](np.random.default_rng(seed), 60_000))


def test_bursts_of_noise_whose_size_varies_have_not_moved() -> None:
    """GARCH [Bollerslev 1986], whose loudest frames come together, by chance of one sign."""
    for seed in range(3):
        rng = np.random.default_rng(seed)
        drawn, power, noise = rng.standard_normal((6, 24_000)), np.ones(6), np.empty((6, 24_000))
        for k, frame in enumerate(drawn.T):
            noise[:, k] = np.sqrt(power) * frame
            power = 0.05 + 0.15 * noise[:, k] ** 2 + 0.8 * power
        assert all(event.white > WHITE for event in events_of(0.02 * noise))


@pytest.mark.parametrize(("T_c", "times", "lasts_s"), [(0.4, 3.6, 18), (0.6, 3.6, 39)])
def test_louder_noise_that_is_correlated_has_not_moved(T_c, times, lasts_s) -> None:
    """Gauss-Markov and white noise that are driven so many times as hard for a while: their
    spectrum is that of before."""
    for seed in range(4):
        rng, time = np.random.default_rng([seed, 4]), np.arange(24_000) / RATE
        loud = np.where((time > 90) & (time < 90 + lasts_s), times, 1)
        share = math.exp(-1 / (T_c * RATE))
        driven = loud * rng.normal(0, 0.06 * math.sqrt(1 - share**2), (6, time.size))
        noise = signal.lfilter([1], [1, -share], driven) + loud * rng.normal(0, 0.02, driven.shape)
        found = events_of(noise)
        assert found and not any(event.moved for event in found)
        assert found[0].time_s == pytest.approx(90, abs=1.2)
        assert found[-1].stop_s == pytest.approx(90 + lasts_s, abs=1.2)


def test_the_largest_is_what_moved_not_what_was_loud() -> None:
    """Noise of five coordinates is six times as large for 5 s, in which the sixth goes away and
    back."""
    time = np.arange(24_000) / RATE
    there = (time > 90) & (time < 95)
    noise = np.random.default_rng(3).normal(0, 0.02, (6, time.size))
    noise[np.arange(6) != 1] *= np.where(there, 6, 1)
    noise[1] += 0.15 * there * np.sin(np.pi * (time - 90) / 5)
    (found,) = events_of(noise)
    assert found.moved and found.largest == "y1"


def test_a_pendulum_in_steps_of_a_file_is_no_recurring_burst() -> None:
    for seed in (3, 9, 10, 11, 15):
        rng, time = np.random.default_rng([seed, 17]), np.arange(30_000) / 60
        x = rng.normal(0, 0.015, time.size) + 0.4 * np.exp(-time / 100) * np.sin(1.2 * np.pi * time)
        assert not np.isfinite(pulses(0.05 * np.round((x + rng.uniform(0, 0.05)) / 0.05), 60, 1e-3))


def test_events_that_recur_have_a_period() -> None:
    """A door every 30 s, now and then without; six bursts at random times have none."""

    def at(time_s: float) -> Event:
        return Event(time_s, 1.0, "burst", ("x1",), "x1", 0.1, 0.0, 1e-9, 9.0, 1.0)

    rng = np.random.default_rng(2)
    doors = 40 + 30 * np.delete(np.arange(25), [4, 11, 12]) + rng.uniform(-0.5, 0.5, 22)
    assert recurrence([at(time) for time in doors]) == pytest.approx(30, abs=0.1)
    assert not np.isfinite(recurrence([at(time) for time in doors[:5]]))
    random = [recurrence([at(t) for t in rng.uniform(0, 900, 6)]) for _ in range(2000)]
    assert np.isfinite(random).mean() < 0.002


def test_bursts_that_recur_for_two_minutes() -> None:
    """To a quarter of the minute that is looked at."""
    t = np.arange(60_000) / 100
    ring = 0.1 * np.exp(-(t % 2.9) / 0.15) * np.sin(50 * t) * ((t > 200) & (t < 320))
    x = 0.02 * np.random.default_rng(3).standard_normal(t.size) + ring
    found = recurring_bout(x, 100.0, 1e-3, blocks(x, 100.0))
    assert found == pytest.approx((2.9, 200, 320), abs=15)


def test_a_step_moves_and_several_knocks_are_told_apart() -> None:
    """A step of 5 standard deviations is no louder noise, beside a cycle either; three frames off,
    four times in 5 s, are no movement of 5 s."""
    rng = np.random.default_rng(5)
    position = rng.normal(0, 0.02, (6, 7200))
    position[1, 3600:] += 0.1
    (event,) = events_of(position)
    assert event.moved and event.stays and event.time_s == pytest.approx(30, abs=0.1)
    (event,) = events_of(position + 0.04 * np.sin(np.arange(7200) / RATE / 5 - 6))
    assert event.moved and event.stays and event.time_s == pytest.approx(30, abs=1.5)
    position = rng.normal(0, 0.02, (6, 7200))
    for second in (30.0, 31.3, 33.0, 34.9):
        position[:3, round(second * RATE) :][:, :3] += 0.5
    knocked = position[:1] + 0.2 * (np.arange(7200) % 600 < 8)  # each among others
    found = events_of(np.vstack([knocked, position[1:]]))
    assert found and all(event.moved for event in found)
    (event,) = events_of(position)
    assert event.often and event.duration_s == pytest.approx(4.9, abs=0.1)
    position[1, round(31.3 * RATE) : round(33.1 * RATE)] -= position[1, 3000]
    position[1, 3756:3996] = position[1, 3000:3240]  # y1 has the first alone
    (event,) = events_of(position)
    assert event.often


def test_an_event_has_both_its_ends_and_noise_between_events_is_compared_as_it_is() -> None:
    """2.5 standard deviations off for 4 s, of which one end is surer than the other: begin and
    duration of all but two of those that are found. Noise that doubles for 200 s from a knock on:
    its ratio at the end."""
    found, time = [], np.arange(72_000) / RATE
    for seed in range(6):
        rng = np.random.default_rng([seed, 9])
        position = rng.normal(0, 0.02, (6, time.size))
        begins = np.arange(60, 600, 100.0) + rng.uniform(0, 50, 6)
        position[0] += 0.05 * np.any((time - begins[:, None]) % 1e9 < 4, axis=0)
        for event in events_of(position):
            late = event.time_s - begins[np.abs(begins - event.time_s).argmin()]
            found.append(abs(late) < 0.1 and abs(event.duration_s - 4) < 0.2)
    assert len(found) >= 30 and found.count(False) <= 2
    loud = (time > 200) & (time < 400)
    position[:3] = rng.normal(0, 0.02, (3, time.size)) * (1 + loud)
    position[0] += 0.5 * ((time > 200) & (time < 200.5))
    last = events_of(position)[-1].most_changed
    assert last.lower < 0.5 < last.upper and last.upper / last.lower < 1.2


def test_the_interval_of_a_shift_knows_noise_of_seconds() -> None:
    """A step of 0.6 mm in Gauss-Markov noise of 4 s: 95 % intervals hold it in 8 of 10 or more, as
    the level has two seconds and its scatter ten on each side."""
    held = []
    for seed in range(30):
        rng = np.random.default_rng([seed, 3])
        position = rng.normal(0, 0.02, (6, 7200))
        position += [gauss_markov(4.0, 0.05)(rng, 7200, RATE) for _ in NAMES]
        position[1, 3600:] += 0.6
        low, high = max(events_of(position), key=lambda e: e.size_mm).shift_ends_mm
        held.append(low < 0.6 < high)
    assert np.mean(held) >= 0.8


@pytest.mark.parametrize("step", [0.0, 0.013])
@pytest.mark.parametrize("factor", [1.5, 2.0, 3.0, 4.0])
def test_louder_noise_that_stays_is_a_change_of_level_and_no_burst(factor, step) -> None:
    """At 225 s, within a point of the levels; in steps of twice the noise, too."""
    rng, loud = np.random.default_rng(53), np.where(np.arange(60_000) < 27_000, 1.0, factor)
    position = rng.normal(0, 0.0067, (6, 60_000)) * loud
    position[3] += 400
    (event,) = events_of(np.round(position / step) * step if step else position)
    assert event.kind == "level" and event.time_s == pytest.approx(225, abs=10)
    assert step or all(side.lower < factor < side.upper for side in event.sides)


def test_steps_of_one_axis_are_no_events() -> None:
    """Of 0.1 mm in noise of 0.03 mm: nine frames of ten have one value."""
    position = np.random.default_rng(6).normal(0, 0.03, (6, 36_000))
    position[2] = np.round(position[2], 1)
    assert not events_of(position)


def test_size_of_an_event_that_a_recording_begins_with() -> None:
    """A marker that comes to rest from 0.5 mm off."""
    position = 1000 + np.random.default_rng(4).normal(0, 0.02, (6, 100_000))
    position[0] += 0.5 * np.exp(-np.arange(100_000) / RATE / 3)
    event = events_of(position)[0]
    assert event.time_s == 0 and event.largest == "x1"
    assert event.size_mm == pytest.approx(0.5, rel=0.1)
