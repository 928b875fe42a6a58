"""A twin's recording against closed forms, a root finder and the published order of flashes."""

from __future__ import annotations

import numpy as np
import pytest
from mocap_workflow.calibration_twins import twin_from_mapping

from mocap_metrology.lighthouse.decode.ootx import accel_of, encode_frame, up_of
from mocap_metrology.lighthouse.records import Factory
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.simulate.recording import simulate, sweep_width

SITE = {
    "seed": 4,
    "master": {"id": 11, "mode": "b"},
    "slave": {"id": 12, "mode": "c", "position_m": [0.4, 2.2, 0.1], "rotation_deg": [8, 3, -40]},
    "motion": {"pattern": "still", "centre_m": [3, 0.8, -0.1]},
    "duration_s": 0.5,
}
CYCLE_S = 400_000 / 48e6


def made(**changes):
    return simulate(twin_from_mapping({**SITE, **changes}))


def moving(**changes):
    return {**SITE["motion"], "pattern": "line", "speed_m_s": 1.0, "extent_m": 0.4, **changes}


def test_still_board_is_seen_under_atan2():
    recording = made()
    truth, hits = recording.truth, recording.truth.hits
    R, p = truth.motion.poses(np.zeros(1))
    diodes = truth.board @ R[0].T + p[0]
    for station in (0, 1):
        pose = recording.twin.stations[station]
        x, y, z = pose.R.T @ (diodes - pose.t).T
        for axis, angle in enumerate((np.arctan2(y, x), np.arctan2(z, x))):
            own = hits.take((hits.station == station) & (hits.axis == axis))
            assert len(own) == 15 * 32  # a sweep each 33 ms
            assert np.abs(own.angle_rad - angle[own.diode]).max() < 1e-12
            after = own.time_s - truth.clocks[station].start(own.cycle)
            assert np.abs(after - (angle[own.diode] / np.pi + 0.5) * CYCLE_S).max() < 1e-12


def test_moving_board_is_hit_when_the_fan_meets_the_diode():
    """The time at which the fan's angle equals the diode's direction, found by brentq."""
    from scipy.optimize import brentq

    speed = 2.0
    twin = twin_from_mapping({**SITE, "motion": moving(speed_m_s=speed, wobble_deg=0)})
    truth = simulate(twin).truth
    hits = truth.hits
    _, p = truth.motion.poses(np.linspace(0, 0.5, 2001))
    assert np.linalg.norm(np.gradient(p, 0.5 / 2000, axis=0), axis=1).max() <= speed * (1 + 1e-6)
    for row in np.linspace(0, len(hits) - 1, 60).astype(int):
        station, axis, diode = hits.station[row], hits.axis[row], hits.diode[row]
        pose = twin.stations[station]
        begin = truth.clocks[station].start(hits.cycle[row])

        def ahead(t, pose=pose, begin=begin, axis=axis, diode=diode):
            R, p = truth.motion.poses(np.array([t]))
            q = pose.R.T @ (R[0] @ truth.board[diode] + p[0] - pose.t)
            fan = np.pi * (t - begin) / CYCLE_S - np.pi / 2
            return fan - np.arctan2(q[1 + axis], q[0])

        found = brentq(ahead, begin + 1e-3, begin + 7e-3, xtol=1e-15, rtol=1e-14)
        assert abs(found - hits.time_s[row]) < 2e-12


def test_factory_values_and_lasers_move_the_hits_by_the_published_formula():
    """Phase shifts an angle by itself; the tilt by asin(z tan(tilt) / r); a laser by its parallax.

    Terms one by one as the Crazyflie firmware writes them.
    """
    tilt = float(np.float16(-0.0091))
    phase = float(np.float16(0.05))
    factory = {"phase": [0.05, 0], "tilt": [-0.0091, 0]}
    lasers = [[0.004, -0.006, 0.0], [0.0, 0.0, 0.008]]
    recording = made(master={**SITE["master"], "factory": factory, "lasers_m": lasers})
    hits = recording.truth.hits
    R, p = recording.truth.motion.poses(np.zeros(1))
    x, y, z = (recording.truth.board @ R[0].T + p[0]).T
    azimuth = np.arctan2(y + 0.006, x - 0.004)
    azimuth -= phase + np.arcsin(z * np.tan(tilt) / np.hypot(x - 0.004, y + 0.006))
    elevation = np.arctan2(z - 0.008, x)
    for axis, angle in enumerate((azimuth, elevation)):
        own = hits.take((hits.station == 0) & (hits.axis == axis))
        assert np.abs(own.angle_rad - angle[own.diode]).max() < 1e-12


@pytest.mark.parametrize(("range_m", "width_us"), [(1, 8.0), (2, 4.0), (4, 2.0), (6, 1.33)])
def test_width_of_a_sweep_falls_with_distance(range_m, width_us):
    assert sweep_width(range_m, 3e-3, CYCLE_S) == pytest.approx(width_us * 1e-6, rel=0.01)


def test_widths_in_a_recording():
    recording = made()
    R, p = recording.truth.motion.poses(np.zeros(1))
    places = recording.truth.board @ R[0].T + p[0]
    hits = recording.hits.take(recording.hits.station == 1)
    r = np.linalg.norm(places[hits.diode] - recording.twin.slave.t, axis=1)
    assert np.allclose(hits.width_s, 3e-3 / (r * np.pi / CYCLE_S), rtol=1e-9)


def flashes_of(recording):
    """Start and length of flashes, one for all diodes, in order."""
    pulses = recording.pulses
    long = pulses.length_s > 45e-6
    start, first = np.unique(np.round(pulses.start_s[long], 9), return_index=True)
    return start, pulses.length_s[long][first]


# skip and axis of the master's and the slave's flash, and who sweeps: four cycles of 400 000 ticks.
ORDER = [(1, 0, 0, 0), (1, 1, 0, 1), (0, 0, 1, 0), (0, 1, 1, 1)]


@pytest.mark.parametrize("start_cycle", [0.0, 1.3, 2.0, 3.97])
@pytest.mark.parametrize("slave_mode", ["c", "A"])
def test_flashes_in_the_published_order(start_cycle, slave_mode):
    slave = {**SITE["slave"], "mode": slave_mode}
    recording = made(start_cycle=start_cycle, slave=slave, flash_shortfall_us=5.0)
    start, length = flashes_of(recording)
    ticks = (length + 5e-6) * 48e6
    code = np.rint((ticks - 3000) / 500).astype(int)
    assert np.abs(ticks - 3000 - 500 * code).max() < 1e-3
    for t, value in zip(start, code, strict=True):
        since = t / CYCLE_S + start_cycle  # whole for the master, + 0.05 for the slave
        slave_flash = since - np.floor(since + 1e-6) > 0.04
        master_skip, master_axis, slave_skip, slave_axis = ORDER[int(since + 1e-6) % 4]
        skip, axis = (slave_skip, slave_axis) if slave_flash else (master_skip, master_axis)
        assert (value >> 2, value & 1) == (skip, axis)
    apart = np.diff(start)
    assert np.allclose(apart[apart < 1e-3], 20_000 / 48e6, atol=1e-8)
    pattern = np.array([(1, 0), (1, 1), (0, 0), (0, 1)])  # who sweeps in a cycle, and which axis
    hits = recording.hits
    assert np.array_equal(np.stack([hits.station, hits.axis], 1), pattern[hits.cycle % 4])


def test_one_station_alone_sweeps_in_every_cycle():
    alone = made(slave=None, master={"id": 5, "mode": "A"})
    assert np.array_equal(np.unique(alone.hits.cycle), np.arange(60))
    assert np.array_equal(alone.hits.axis, alone.hits.cycle & 1)
    assert alone.truth.R is None
    start, _ = flashes_of(alone)
    assert np.allclose(np.diff(start), CYCLE_S, atol=1e-8)


def test_bits_of_the_flashes_are_the_frame_of_the_station():
    factory = {"phase": [0.02571, 0.05408], "gibphase": [2.3672, -1.0996]}
    recording = made(
        duration_s=3.2, tilt_deg=[4, 20], master={**SITE["master"], "factory": factory}
    )
    start, length = flashes_of(recording)
    code = np.rint(((length + 5.2e-6) * 48e6 - 3000) / 500).astype(int)
    since = start / CYCLE_S
    bits = code[np.abs(since - np.rint(since)) < 0.01] >> 1 & 1
    pairs = {k: np.float16(v).astype(float) for k, v in factory.items()}
    # The master stands tilted: its x axis 20 deg below, its y axis 4 deg above the horizon.
    up = from_angles(np.radians(4), np.radians(20), 0)[2]
    accel = recording.truth.stations[0].gravity
    assert np.allclose(accel, up)
    frame = encode_frame(Factory(**pairs), 11, "b", accel_of(up))
    assert any(np.array_equal(np.roll(frame, -i), bits[:358]) for i in range(358))


def test_gravity_of_both_stations_agrees_through_the_true_rotation():
    truth = made(tilt_deg=[-6, 25]).truth
    master, slave = (station.gravity for station in truth.stations)
    assert np.allclose(truth.R @ slave, master, atol=1e-12)
    stated = [up_of(accel_of(up)) for up in (master, slave)]
    assert np.degrees(np.arccos(stated[0] @ truth.R @ stated[1])) < 0.7  # bytes, 0.5 deg


def test_noise_has_its_common_and_its_independent_part():
    """Monte Carlo: 2 sweeps x 60 Hz x 20 s; tolerance 4 standard errors."""
    recording = made(duration_s=20, common_urad=53, independent_urad=30, seed=77)
    hits, truth = recording.hits, recording.truth.hits
    off = 1e6 * (hits.angle_rad - truth.angle_rad)
    assert np.allclose(off, 1e6 * (hits.time_s - truth.time_s) * np.pi / CYCLE_S, atol=1e-3)
    table = off.reshape(-1, 32)  # a still board: all diodes of a sweep one after another
    assert (np.diff(hits.cycle.reshape(-1, 32), axis=1) == 0).all()
    n = len(table)
    independent = np.sqrt(table.var(axis=1, ddof=1).mean())
    common = np.sqrt(table.mean(axis=1).var(ddof=1) - independent**2 / 32)
    assert independent == pytest.approx(30, abs=4 * 30 / np.sqrt(2 * 31 * n))
    assert common == pytest.approx(53, abs=4 * 53 / np.sqrt(2 * n))
    means = table.mean(axis=1)
    assert abs(np.corrcoef(means[1:], means[:-1])[0, 1]) < 4 / np.sqrt(n)


def test_clock_runs_fast_and_jitter_is_of_the_flashes():
    recording = made(clock_ppm=400, sync_jitter_us=2, duration_s=4)
    pulses = recording.pulses
    first = (pulses.diode == 0) & (pulses.length_s > 45e-6)
    t = pulses.start_s[first]
    cycle = CYCLE_S * (1 + 400e-6)
    phase = t - np.rint(t / cycle) * cycle
    master = t[phase < 2e-4]
    slope, off = np.polyfit(np.rint(master / cycle), master, 1)
    assert slope == pytest.approx(cycle, abs=4 * 2e-6 * np.sqrt(12 / 480**3))
    assert np.std(master - np.polyval([slope, off], np.rint(master / cycle))) == pytest.approx(
        2e-6, rel=4 / np.sqrt(2 * 480)
    )


def test_same_seed_same_recording_and_noise_leaves_motion_and_dropouts():
    quiet, again = made(dropout=0.2), made(dropout=0.2)
    assert np.array_equal(quiet.pulses.start_s, again.pulses.start_s)
    noisy = made(dropout=0.2, common_urad=53, independent_urad=30, sync_jitter_us=0.1)
    assert np.array_equal(noisy.truth.hits.time_s, quiet.truth.hits.time_s)
    other = simulate(quiet.twin, seed=5)
    assert len(other.hits) != len(quiet.hits)


def test_truth_between_the_optical_origins():
    """Azimuth sees its laser's y, elevation its laser's z; in depth they differ, the middle holds.

    A housing pushed so that its optical origin is where it was is seen under the same angles, up to
    half the difference in depth, 8 mm at 3 m.
    """
    lasers = [[0.01, -0.004, 0.5e-3], [-0.006, 0.002, 0.007]]
    recording = made(master={**SITE["master"], "lasers_m": lasers})
    moved = recording.truth.t_m - recording.truth.t_optical_m
    assert np.allclose(moved, [0.002, -0.004, 0.007])
    R, p = recording.truth.motion.poses(np.zeros(1))
    x, y, z = (recording.truth.board @ R[0].T + p[0] - moved).T
    hits = recording.truth.hits.take(recording.truth.hits.station == 0)
    angle = np.where(hits.axis == 0, np.arctan2(y, x)[hits.diode], np.arctan2(z, x)[hits.diode])
    assert np.abs(hits.angle_rad - angle).max() < 0.008 / 3 * np.tan(np.abs(angle).max())
