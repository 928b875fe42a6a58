"""A twin's recording against closed forms, a root finder and the published order of flashes; what
is lost or added, in shares within four standard errors; its words bit by bit."""

import numpy as np
import pytest
from mocap_workflow.calibration_twins import twin_from_mapping

from mocap_metrology.lighthouse.decode.ootx import accel_of, encode_frame, up_of
from mocap_metrology.lighthouse.records import Factory
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.rotor import VARIANTS, angles, rotor_parameters
from mocap_metrology.lighthouse.simulate.recording import simulate

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


STATION = {"factory": {"phase": [0.05, 0], "tilt": [-0.0091, 0.02], "gibmag": [0.01, -0.02]},
           "lasers_m": [[0.004, -0.006, 0.001], [-0.003, 0.002, 0.008]]}  # fmt: skip


@pytest.mark.parametrize("variant", ["crazyflie", "libsurvive", "astrobee"])
@pytest.mark.parametrize(("optics", "ppm"), [({}, 0), (STATION, 400)])
def test_still_board_is_seen_under_the_angles_of_its_optics(variant, optics, ppm):
    """Of which `test_rotor` has the formula; pulses last aperture / (range pi / cycle) + beam."""
    recording = made(
        master={**SITE["master"], **optics},
        variant=variant,
        clock_ppm=ppm,
        beam_us=1.5,
        aperture_mm=4,
    )
    truth, hits, cycle_s = recording.truth, recording.hits, CYCLE_S * (1 + 1e-6 * ppm)
    R, p = truth.motion.poses(np.zeros(1))
    diodes = truth.board @ R[0].T + p[0]
    for station, twin in enumerate(recording.twin.stations):
        points = np.ascontiguousarray((diodes - twin.t) @ twin.R)
        lasers = np.array(twin.lasers_m)
        angle = angles(points, rotor_parameters(twin.optics, lasers, VARIANTS[variant]))
        if not optics:
            assert np.allclose(angle, np.arctan2(points[:, 1:], points[:, :1]), atol=1e-14)
        for axis in (0, 1):
            own = hits.take((hits.station == station) & (hits.axis == axis))
            assert len(own) == 15 * 32  # a sweep each 33 ms
            assert np.abs(own.angle_rad - angle[own.diode, axis]).max() < 1e-12
            after = own.time_s - truth.clocks[station].start(own.cycle)
            assert np.abs(after - (angle[own.diode, axis] / np.pi + 0.5) * cycle_s).max() < 1e-12
            r = np.linalg.norm(points - lasers[axis], axis=1)[own.diode]
            assert np.allclose(own.width_s, 4e-3 / (r * np.pi / cycle_s) + 1.5e-6, rtol=1e-9)


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
    slave = recording.truth.stations[1].gravity
    assert np.allclose(recording.truth.R @ slave, up, atol=1e-12)
    stated = [up_of(accel_of(own)) for own in (up, slave)]
    assert np.degrees(np.arccos(stated[0] @ recording.truth.R @ stated[1])) < 0.7  # bytes, 0.5 deg
    assert any(np.array_equal(np.roll(frame, -i), bits[:358]) for i in range(358))
