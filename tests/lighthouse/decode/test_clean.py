"""Cleaning: wrong hits planted in true ones, on moving and still, flat and solid boards."""

from dataclasses import replace

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.decode.clean import (
    RESOLUTION_RAD,
    USUAL,
    clean_hits,
    neighbour_outliers,
    pose_outliers,
    still_outliers,
    sweep_outliers,
)
from mocap_metrology.lighthouse.records import Hits

SHARED_RAD, OWN_RAD = 53e-6, 30e-6


def solid_board(rng: np.random.Generator) -> np.ndarray:
    """As a headset: 32 diodes on a half shell."""
    direction = rng.normal(size=(32, 3))
    direction[:, 0] = -np.abs(direction[:, 0])
    return 0.11 * direction / np.linalg.norm(direction, axis=1, keepdims=True)


def scene(
    board: np.ndarray, rng: np.random.Generator, speed: float, range_m: float = 2.0, seen: int = 99
) -> Hits:
    """Two stations, 240 sweeps of each laser; noise that a sweep shares, and each diode's own."""
    columns: list[list] = [[] for _ in range(6)]
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    visible = rng.permutation(len(board))[:seen]
    for cycle in range(960):
        station, axis = cycle // 2 % 2, cycle % 2
        way = speed * 0.0083333 * cycle
        spin = 0.5 * way
        c, s = np.cos(spin), np.sin(spin)
        roll = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        at = (range_m, 0.3 - 0.2 * station + 0.3 * np.sin(way), 0.2 * np.cos(way))
        point = board[visible] @ (turn @ roll).T + at
        angle = np.arctan2(point[:, 1 + axis], point[:, 0])
        angle = angle + SHARED_RAD * rng.normal() + OWN_RAD * rng.normal(size=angle.size)
        time_s = cycle / 120 + (angle / np.pi + 0.5) / 120
        row = (station, axis, cycle, visible, time_s, angle)
        for column, value in zip(columns, row, strict=True):
            column.append(np.broadcast_to(value, visible.size))
    columns = [np.concatenate(c) for c in columns]
    hits = Hits(*columns, np.full(columns[0].size, 5e-6))
    return hits.take(np.argsort(hits.time_s))


def spoil(
    hits: Hits, rng: np.random.Generator, share: float, least: float
) -> tuple[Hits, np.ndarray]:
    """Some hits off by at least `least` and up to 0.11 rad."""
    wrong = rng.uniform(size=len(hits)) < share
    off = np.where(wrong, rng.choice([-1, 1], len(hits)) * rng.uniform(least, 0.11, len(hits)), 0.0)
    return replace(hits, angle_rad=hits.angle_rad + off), wrong


@pytest.mark.parametrize("speed", [0.0, 1.0])
@pytest.mark.parametrize("range_m", [1.0, 2.0, 5.0])
def test_flat_board(speed: float, range_m: float) -> None:
    """Nothing true goes and every wrong one beyond the gate does, at any tilt."""
    rng = np.random.default_rng(1)
    hits, wrong = spoil(scene(flat_board(), rng, speed, range_m), rng, 0.03, 2.5e-3)
    np.testing.assert_array_equal(sweep_outliers(hits, flat_board()), wrong)


@pytest.mark.parametrize(("seen", "caught"), [(32, 0.98), (14, 0.8)])
def test_solid_board(seen: int, caught: float) -> None:
    """With 14 of 32 diodes seen, some stand so much apart that no other can tell of them."""
    rng = np.random.default_rng(3)
    board = solid_board(rng)
    clean = scene(board, rng, 0.5, seen=seen)
    assert not sweep_outliers(clean, board).any()
    hits, wrong = spoil(clean, rng, 0.02, 5e-3)
    found = sweep_outliers(hits, board)
    assert np.mean(found[wrong]) > caught
    assert np.mean(found[~wrong]) < 0.01


@pytest.mark.parametrize(("seen", "missed"), [(5, 0.2), (7, 0.08), (9, 0.04)])
def test_few_hits_of_a_solid_board(seen: int, missed: float) -> None:
    """8 mrad, below the ten hits of perspective: the affine part alone lets 15 to 100 % pass. What
    cannot be distinguished goes too, 3 % of the true ones; without wrong hits nothing goes."""
    rng = np.random.default_rng(7)
    board = solid_board(rng)
    true = scene(board, rng, 0.5, seen=seen)
    wrong = rng.uniform(size=len(true)) < 0.02
    off = np.where(wrong, 8e-3 * rng.choice([-1, 1], len(true)), 0)
    hits = replace(true, angle_rad=true.angle_rad + off)
    affine = sweep_outliers(hits, board)
    assert affine[wrong].mean() < 0.88
    passed = np.flatnonzero(~affine)
    more = pose_outliers(hits.take(passed), board, USUAL)
    left = passed[~more]
    assert wrong[left].sum() <= missed * wrong.sum()
    assert (~wrong[left]).sum() > 0.96 * (~wrong).sum()
    assert not pose_outliers(true, board, USUAL).any()


def test_hampel_where_the_board_is_still() -> None:
    """Below the gate of the sweep, at twice its noise: seen in time, not in the sweep."""
    rng = np.random.default_rng(6)
    hits = scene(flat_board(), rng, 0.0)
    wrong = np.zeros(len(hits), bool)
    wrong[rng.choice(len(hits), 200, replace=False)] = True
    hits = replace(hits, angle_rad=hits.angle_rad + np.where(wrong, 1.2e-3, 0))
    assert not sweep_outliers(hits, flat_board()).any()
    found = still_outliers(hits, USUAL, RESOLUTION_RAD)
    assert found[wrong].all()
    assert np.mean(found[~wrong]) < 1e-3
    kept, report = clean_hits(hits, flat_board())
    assert (np.diff(kept.time_s) >= 0).all()
    assert len(kept) == np.count_nonzero(~found)
    assert report["still"] == np.bincount(hits.diode[found], minlength=32).tolist()
    assert report["kept"] == np.bincount(kept.diode, minlength=32).tolist()
    assert sum(report["sweep"]) == 0


def test_board_without_a_place_for_a_diode() -> None:
    rng = np.random.default_rng(9)
    with pytest.raises(Refusal, match="expected a position for each"):
        clean_hits(scene(flat_board(), rng, 0.0), flat_board()[:30])


@pytest.mark.parametrize("speed", [0.0, 0.5, 1.5])
def test_wrong_hits_of_collisions(speed: float) -> None:
    """Of every second sweep three hits in five are lost and a tenth is of another station: of what
    remains one in five, too many for a sweep alone. The turns before and after tell."""
    rng = np.random.default_rng(3)
    board = solid_board(rng)
    hits = scene(board, rng, speed, seen=14)
    hits = replace(hits, cycle=hits.cycle // 4)  # a turn has both planes
    collide = hits.cycle % 2 == 1
    draw = rng.uniform(size=len(hits))
    wrong = collide & (draw > 0.9)
    off = rng.choice([-1, 1], len(hits)) * rng.uniform(0.02, 0.1, len(hits))
    kept = ~collide | (draw > 0.6)
    mixed = replace(hits, angle_rad=hits.angle_rad + wrong * off).take(kept)
    wrong = wrong[kept]
    found = neighbour_outliers(mixed, board, USUAL)
    assert found[wrong].all()
    assert found[~wrong].mean() < 0.002
    alone = sweep_outliers(mixed, board)
    assert alone[wrong].mean() < 0.6
