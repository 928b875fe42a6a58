"""Residuals by angle, time and diode: of recordings with a fault, and against sums by hand."""

import numpy as np
import pytest

from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.batch.residuals import BINS
from mocap_metrology.lighthouse.calibrate.batch import Scene, by_batch
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.simulate.recording import simulate
from tests.lighthouse.batch.test_batch import twin


def residuals(hits: Hits, board: np.ndarray) -> dict:
    scene = Scene(hits, board, "ideal", [None, None], None, "crazyflie", Priors())
    return by_batch(scene).details["residuals"]


def curves(found: dict, against: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """Means and their standard deviations in urad, of both stations and axes."""
    rows = [row for row in found["against"] if row["against"] == against]
    assert len(rows) == 4
    return [(np.array(row["mean_urad"]), np.array(row["sd_urad"])) for row in rows]


@pytest.fixture(scope="module")
def sound() -> dict:
    made = simulate(twin(31))
    return residuals(made.hits, made.truth.board)


def test_a_station_that_moves_leaves_a_step_in_time(sound: dict) -> None:
    """By 5 mm at 2.6 s of 5: means of both parts have opposite signs."""
    moved = simulate(twin(31, slave={"position_m": (0.503, 2.504, 0.3)}))
    whole = simulate(twin(31))
    early, late = whole.hits.time_s < 2.6, moved.hits.time_s >= 2.6
    parts = whole.hits.take(early), moved.hits.take(late)
    hits = Hits(
        **{
            name: np.concatenate([getattr(part, name) for part in parts])
            for name in Hits.__dataclass_fields__
        }
    )
    found = residuals(hits, whole.truth.board)
    steps = [
        abs(mean[: BINS // 2 - 1].mean() - mean[BINS // 2 + 1 :].mean())
        for mean, _ in curves(found, "time_s")
    ]
    before = [
        abs(mean[: BINS // 2 - 1].mean() - mean[BINS // 2 + 1 :].mean())
        for mean, _ in curves(sound, "time_s")
    ]
    assert max(steps) > 100 > 4 * max(before)


def test_a_displaced_diode_has_its_residual_though_it_is_excluded() -> None:
    """4 mm along y at about 3 m are 1.3 mrad of azimuth: rms over both axes near 1 mrad."""
    made = simulate(twin(7))
    wrong = made.truth.board.copy()
    wrong[13] += [0.0, 0.004, 0.0]
    for row in residuals(made.hits, wrong)["by_diode"]:
        assert row["excluded"] == [13]
        rms = dict(zip(row["diode"], row["rms_urad"], strict=True))
        assert 600 < rms.pop(13) < 1600 and max(rms.values()) < 100
        assert row["n"][row["diode"].index(13)] > 200
