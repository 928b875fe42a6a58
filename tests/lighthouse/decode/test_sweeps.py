"""Hits: angles of scenes whose every hit is known, and of a real recording as libsurvive has it."""

import gzip

import numpy as np
import pytest

from mocap_metrology.lighthouse.decode.flashes import find_flashes, find_hits
from mocap_metrology.lighthouse.records import Hits, Pulses

from .synthetic import TICK, Scene, add, drop

QUANTISATION_RAD = 38.5e-6  # middle of two edges at 2 MHz, and none of the flash


def truth(scene: Scene, hits: Hits) -> np.ndarray:
    """Rows of the true hits (station, axis, cycle, diode, time, angle) in the order of the hits."""
    known = {(int(s), int(c), int(d)): (a, t, x) for s, a, c, d, t, x in scene.hits}
    first = round((hits.time_s[0] - scene.begin_s) / scene.cycle_s - 0.5)
    shift = first - int(hits.cycle[0])
    rows = [
        known[s, c + shift, d]
        for s, c, d in zip(
            hits.station.tolist(), hits.cycle.tolist(), hits.diode.tolist(), strict=True
        )
    ]
    return np.array(rows)


def check(scene: Scene, hits: Hits, rms: float = 1.3 * QUANTISATION_RAD) -> np.ndarray:
    true = truth(scene, hits)
    np.testing.assert_array_equal(hits.axis, true[:, 0])
    assert np.abs(hits.time_s - true[:, 1] - 0.25e-6).max() < 0.51e-6
    error = hits.angle_rad - true[:, 2]
    assert np.sqrt(np.mean(error**2)) < rms
    assert (np.diff(hits.time_s) >= 0).all()
    return error


def hits_of(pulses: Pulses) -> tuple[Hits, dict[str, list[int]]]:
    return find_hits(pulses, find_flashes(pulses))


def total(report: dict[str, list[int]]) -> dict[str, int]:
    return {reason: sum(count) for reason, count in report.items() if sum(count)}


SCENES = {  # and the largest rms of its angles over quantisation
    # 83 ppm off the nominal period, which would err by 87 urad at 60 deg
    **{f"moving, phase {k}": (1.05, {"seconds": 4.0, "phase": k, "velocity": (0.1, -0.15, 0.08),
                                     "cycle_s": 400_000 * TICK * (1 + 83.1e-6), "width_s": 4.3e-6})
       for k in range(4)},
    # two samples, two or three, and a near station
    **{f"{us} us wide": (2, {"width_s": 1e-6 * us, "velocity": (0.1, 0.05, 0.08)})
       for us in (1.0, 1.4, 20)},
    **{f"alone, phase {k}": (2, {"stations": (0,), "alone": True, "phase": k}) for k in (0, 1)},
}  # fmt: skip


@pytest.mark.parametrize("case", SCENES)
def test_scenes_of_every_kind(case: str) -> None:
    rms, keys = SCENES[case]
    scene = Scene(**keys).build()
    hits, report = hits_of(scene.pulses())
    error = check(scene, hits, rms * QUANTISATION_RAD)
    if "moving" in case:
        for station in (0, 1):
            assert abs(error[hits.station == station].mean()) < 5e-6
    assert total(report)["hit"] == len(hits)
    assert set(total(report)) == {"flash", "hit"}
    assert len(hits) > 0.98 * 32 * scene.seconds / scene.cycle_s


def test_reflections_and_stray_light() -> None:
    scene = Scene(width_s=5e-6).build()
    pulses = scene.pulses()
    rng = np.random.default_rng(4)
    short = np.flatnonzero(pulses.length_s < 40e-6)
    moved = np.isin(np.arange(pulses.start_s.size), short[::60])
    twice = rng.choice(np.setdiff1d(short, short[::60]), 300, replace=False)
    late = np.where(rng.uniform(size=300) < 0.5, -200e-6, 250e-6)
    few = short[::50]
    lonely = add(
        drop(pulses, moved),
        np.concatenate(
            [pulses.start_s[twice] + late, pulses.start_s[few] + 4.5e-3, pulses.start_s[moved]]
        ),
        np.repeat([3.5e-6, 5e-6, 30e-6], [300, few.size, moved.sum()]),
        np.concatenate([pulses.diode[twice], pulses.diode[few], pulses.diode[moved]]),
    )
    hits, report = hits_of(lonely)
    check(scene, hits, 2 * QUANTISATION_RAD)
    assert total(report)["second_on_diode"] == pytest.approx(300, abs=10)
    assert total(report)["width"] == pytest.approx(moved.sum(), abs=2)
    assert total(report)["no_sweep"] == pytest.approx(few.size, abs=5)
    assert sum(map(sum, report.values())) == lonely.start_s.size
    assert np.array_equal(report["hit"], np.bincount(hits.diode, minlength=32))


def libsurvive_angles(path, name: bytes) -> tuple[np.ndarray, int]:
    """A lines (diode, acode, tick, length, angle, lighthouse) and the first tick of the C lines."""
    angles, ticks = [], []
    with gzip.open(path) as lines:
        for line in lines:
            field = line.split()
            if field[1:3] == [name, b"A"]:
                angles.append([float(x) for x in field[3:9]])
            elif field[1:3] == [name, b"C"]:
                ticks.append(int(field[4]))
    since = (np.array(ticks) - ticks[0] + 2**31) % 2**32 - 2**31
    return np.array(angles), ticks[int(np.argmin(since))]


@pytest.fixture(scope="module", params=["HMD", "T20"])
def real(request, samples, headset) -> tuple:
    """Decoded pulses of an object in a real recording, and libsurvive's own angles of it."""
    path = samples / "lighthouse/libsurvive_extras/lh1_test_cal.rec.gz"
    pulses = headset[request.param].pulses
    flashes = find_flashes(pulses)
    angles, tick_0 = libsurvive_angles(path, request.param.encode())
    time_s = (angles[:, 2] - tick_0) % 2**32 * TICK
    return flashes, find_hits(pulses, flashes)[0], angles, time_s


def test_real_recording_as_libsurvive_decodes_it(real) -> None:
    """Station, axis and diode of at least 99 % of its angles are ours; the angles agree within 30
    ticks (1 tick: 7.9 urad) for 95 %, 10 in the middle: libsurvive times a sweep by an estimate of
    the flash that lags behind the rotors. Its lighthouse 1 is the master."""
    flashes, hits, angles, time_s = real
    # Times of a diode are milliseconds apart, so that those of all diodes sort on one line
    ours = hits.time_s + 100.0 * hits.diode
    order = np.argsort(ours)
    theirs = time_s + 100.0 * angles[:, 0]
    at = np.searchsorted(ours[order], theirs - 30e-6).clip(max=len(hits) - 1)
    near = order[at]
    found = np.abs(ours[near] - theirs) < 30e-6
    near, angles = near[found], angles[found]
    same = (hits.station[near] == 1 - angles[:, 5]) & (
        hits.axis[near] == angles[:, 1].astype(int) & 1
    )
    assert np.count_nonzero(same) >= 0.99 * found.size
    apart = (hits.angle_rad[near] - angles[:, 4]) / (np.pi / 400_000)
    assert abs(np.median(apart)) < 10
    assert np.quantile(np.abs(apart), 0.95) < 30
    for one in flashes:  # none is missed, though most are seen by one diode
        assert one.cycle.size >= one.cycle[-1] - one.cycle[0]
