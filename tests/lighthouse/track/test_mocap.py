"""A tracked board against motion capture of markers on it: twins with a clock, a frame, levers and
noise of their own."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import chi2

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.calibrate.scene import Scene
from mocap_metrology.lighthouse.simulate.motion import motion_of
from mocap_metrology.lighthouse.simulate.recording import simulate
from mocap_metrology.lighthouse.simulate.turns import stations_around
from mocap_metrology.lighthouse.simulate.twin import MotionTwin
from mocap_metrology.lighthouse.track.markers import Markers, Tracked
from mocap_metrology.lighthouse.track.mocap import match
from mocap_metrology.lighthouse.track.receiver import Calibrated, Track, track
from mocap_metrology.lighthouse.track.resection import as_tracked, resected
from tests.lighthouse import pairs
from tests.lighthouse.batch.planes_scene import made, motion
from tests.lighthouse.pairs import twin

LEVERS = np.array([[0.05, 0.02, 0.08], [-0.04, 0.06, 0.05], [0.0, -0.05, 0.07]])
TURN, SHIFT_M = rotation.exp(np.array([0.4, -1.1, 2.0])), np.array([1.2, -0.7, 0.3])
OFFSET_S, RATE = 2.3, 20e-6


@dataclass
class Lab:
    """A scene, its stations as they are, motion of the board in the frame of motion capture, and
    the board as tracked with these stations."""

    scene: Scene
    true: Calibrated
    moves: object
    found: Track

    def tracked(self) -> Tracked:
        return as_tracked(self.found)


def seen(
    lab: Lab,
    levers: np.ndarray = LEVERS[:1],
    *,
    noise_mm: float = 0.2,
    scale: float = 1.0,
    rate_hz: float = 100.0,
    seconds: float = 12.0,
) -> Markers:
    """Markers by a clock that starts `OFFSET_S` before that of the light and is fast by `RATE`."""
    time_s = np.arange(int(seconds * rate_hz)) / rate_hz
    R, p = lab.moves((time_s - OFFSET_S) / (1 + RATE))
    place = p[:, None] + np.einsum("nij,mj->nmi", R, levers)
    place = scale * place @ TURN.T + SHIFT_M
    place += 1e-3 * noise_mm * np.random.default_rng(8).normal(size=place.shape)
    return Markers(tuple("ABC"[: len(levers)]), rate_hz, np.moveaxis(place, 0, 2))


@pytest.fixture(scope="module")
def three() -> Lab:
    """Stations of the second generation."""
    given = made(3, 3, 8.0)
    R, t = (np.stack(x) for x in zip(*given.poses[1:], strict=True))
    true = Calibrated(R, t, np.zeros((12, 12)), False)
    return Lab(given.scene, true, lambda time_s: motion(time_s, 3), track(given.scene, true))


@pytest.fixture(scope="module")
def pair() -> Lab:
    """Master and slave."""
    own = simulate(twin(5, duration_s=6.0, motion={"wobble_deg": 15}))
    scene = pairs.scene(own)
    true = Calibrated(own.truth.R, own.truth.t_m, np.zeros((6, 6)), False)
    return Lab(scene, true, own.truth.motion.poses, track(scene, true))


def test_clock_frame_and_lever_are_found(three: Lab) -> None:
    """Within four of the stated standard deviations; motion capture began earlier, ended later, and
    saw none of the markers for a second."""
    markers = seen(three)
    markers.place_m[:, :, 500:600] = np.nan
    found = match(three.tracked(), markers)
    at, n = found.free, 8.0 * 60
    assert n - 90 < found.time_s.size < n - 50
    off = np.r_[at.offset_s - RATE * at.middle_s - OFFSET_S, at.rate - RATE]
    off = np.r_[off, (at.lever_m - LEVERS[:1]).ravel()]
    assert np.abs(off / found.sd[:-1]).max() < 4, off / found.sd[:-1]
    assert np.all(found.sd < [5e-5, 2e-5, 1e-4, 1e-4, 1e-4, 1e-4])
    assert abs(at.scale - 1) < 4 * found.sd[-1]
    # 0.2 mm of motion capture in each axis, and the noise of the track
    assert 1e3 * np.sqrt(np.mean(found.place_m**2)) < 0.25
    assert found.turn_rad is None


def test_lost_frames_show_as_a_slip_of_the_clocks(three: Lab) -> None:
    """50 ms of frames are missing without a gap; the speed is 0.3 m/s."""
    markers = seen(three)
    whole = match(three.tracked(), markers)
    assert whole.slip_share < 0.1
    part = replace(markers, place_m=np.delete(markers.place_m, np.arange(620, 625), axis=2))
    found = match(three.tracked(), part)
    assert found.slip_share > 0.5
    assert found.slip_s == pytest.approx(0.05, rel=0.15)


def test_frames_after_a_marker_slipped_are_left_out(three: Lab) -> None:
    """By 8 mm, for the last 4.5 of 12 s."""
    markers = seen(three, LEVERS)
    R, _ = three.moves((np.arange(750, 1200) / markers.rate_hz - OFFSET_S) / (1 + RATE))
    markers.place_m[0, :, 750:] += (R @ [0.008, 0, 0] @ TURN.T).T
    clean = markers.cleaned()
    assert clean.not_rigid == pytest.approx(450 / 1200, abs=0.02)
    assert 1e3 * np.sqrt(np.mean(match(three.tracked(), clean).place_m ** 2)) < 0.25


@pytest.mark.parametrize("generation", [1, 2])
def test_stations_are_resected(generation: int, three: Lab, pair: Lab) -> None:
    """Where they are, within the 99.9 % ellipsoid; the search starts from stations that are wrong
    by 15 mm and 0.5 deg, with which the board was tracked."""
    lab = pair if generation == 1 else three
    fewer = replace(lab.scene, hits=lab.scene.hits.take(slice(None, None, 3)))
    R = lab.true.R.reshape(-1, 3, 3) @ rotation.exp(np.array([0.0, 0.006, 0.006]))
    t = lab.true.t_m.reshape(-1, 3) + np.array([0.009, -0.009, 0.008])
    wrong = replace(lab.true, R=np.squeeze(R), t_m=np.squeeze(t))
    tracked = as_tracked(alone := track(fewer, wrong))
    np.testing.assert_allclose(3 * tracked.noise_m**2, (alone.sd.noise[:, :3] ** 2).sum(axis=1))
    markers = seen(lab)
    found = match(tracked, markers)
    placed = resected(fewer, wrong, tracked, markers, found.free)
    off = []
    for (R_1, t_1), (R_0, t_0) in zip(placed.relative, lab.true.poses[1:], strict=True):
        off += [*(t_1 - t_0), *rotation.error(R_1, R_0)]
    off = np.array(off)
    assert np.abs(off.reshape(-1, 6)[:, :3]).max() < 3e-3
    assert off @ np.linalg.solve(placed.covariance, off) < chi2.ppf(0.999, off.size)
    assert max(placed.rms_rad) < 5e-4


def test_covariance_of_relative_poses_is_that_of_their_derivatives(three: Lab) -> None:
    """Steps of the poses in the frame of motion capture, by differences."""
    from mocap_metrology.lighthouse.track import resection

    fit = resection._Fit([(TURN @ R, TURN @ t + SHIFT_M) for R, t in three.true.poses], np.zeros(7))
    rng, size = np.random.default_rng(2), 18
    steps = 1e-6 * rng.normal(size=(4 * size, size + 7))
    steps[:, size:] = 0
    every = steps.T @ steps / len(steps)

    def relative(one: resection._Fit) -> list:
        return resection.Resected([0, 1, 2], one.poses, np.zeros((0, 0)), [], []).relative

    moved = []
    for step in steps:
        pairs = zip(relative(fit.moved(step)), relative(fit), strict=True)
        moved.append([np.r_[t - t_0, rotation.error(R, R_0)] for (R, t), (R_0, t_0) in pairs])
    moved = np.reshape(moved, (len(steps), -1))
    D = resection.relative_by_poses(fit.poses)
    np.testing.assert_allclose(moved.T @ moved / len(steps), D @ every[:size, :size] @ D.T,
                               rtol=1e-3, atol=1e-16)  # fmt: skip


def test_a_marker_of_another_body_is_refused(three: Lab) -> None:
    """Also where it is far away, or the file is in another unit."""
    for place in ([1.0, 2.0, 0.5], [8.0, 0.0, 1.0]):
        markers = seen(three, LEVERS)
        markers.place_m[2] = np.array(place)[:, None] + 1e-4 * np.cos(np.arange(1200.0))
        with pytest.raises(Refusal, match="no marker keeps its distance from C "):
            markers.cleaned()
    large = replace(seen(three, LEVERS), place_m=1e3 * seen(three, LEVERS).place_m)
    with pytest.raises(Refusal, match="1e\\+03 times as large"):
        match(three.tracked(), large.cleaned())


def circle(time_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    turn = 2 * np.pi * time_s / 2.0
    place = 0.4 * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(turn.size)])
    return np.tile(np.eye(3), (turn.size, 1, 1)), place


def moving(move: object, seconds: float = 6.0) -> Tracked:
    time_s = np.arange(0, seconds, 1 / 60)
    R, p = move(time_s)
    return Tracked(time_s, R, p + 1e-4 * np.random.default_rng(1).normal(size=p.shape), 0 * time_s)


def along_a_line(time_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    R, p = motion(time_s, 3)
    return R, p * [1, 0.01, 0.01]


@pytest.mark.parametrize(
    ("own", "its", "why"),
    [
        (motion, lambda t: motion(t, 77), "expected one motion, recorded by both"),
        (motion, lambda t: tuple(np.array([1, 25.4])[k] * x if k else x
                                 for k, x in enumerate(motion(t, 3))), "25.4 times as large"),
        (along_a_line, along_a_line, "expected 30 mm or more in two"),
        (circle, circle, "the offset of the clocks is not determined"),
        (motion, lambda t: (motion(t, 3)[0], motion(t, 3)[1] * [1, -1, 1]), "mirror image"),
    ],
)  # fmt: skip
def test_what_shows_nothing_is_refused(own: object, its: object, why: str, three: Lab) -> None:
    own = (lambda t: motion(t, 3)) if own is motion else own
    markers = seen(replace(three, moves=its))
    with pytest.raises(Refusal, match=why):
        match(moving(own), markers)


@pytest.mark.parametrize("seed", [5, 8])
def test_a_take_played_backwards_is_refused(seed: int) -> None:
    """To a few centimetres it fits by chance, as one marker may be anywhere on the board."""
    _, t, middle, _ = stations_around(3, np.random.default_rng(seed))
    moves = MotionTwin(centre_m=tuple(middle), speed_m_s=0.6, extent_m=0.6, wobble_deg=15)
    poses = motion_of(moves, t, seed).poses
    track = moving(poses)
    found = match(track, seen(SimpleNamespace(moves=poses))).alignment
    assert found.offset_s == pytest.approx(OFFSET_S, abs=1e-3)
    with pytest.raises(Refusal, match="or more where they were not fitted"):
        match(track, seen(SimpleNamespace(moves=lambda time_s: poses(5.0 - time_s))))


def test_recordings_without_common_time_are_refused(three: Lab) -> None:
    with pytest.raises(Refusal, match=r"with A follow one another for 2\.89 s"):
        match(three.tracked(), seen(three, seconds=2.9))
    late = lambda t: motion(t + 6.0, 3)  # noqa: E731
    with pytest.raises(Refusal, match="no 3 s in common"):
        match(moving(lambda t: motion(t, 3), 2.5), seen(replace(three, moves=late)))
