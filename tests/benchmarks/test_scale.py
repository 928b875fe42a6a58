"""What benchmarks/scale.py writes and reads; the runs themselves take minutes."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.scale import costs, labels, recording, store
from benchmarks.scale_figure import measured
from mocap_metrology.io.read import read_recording


def test_its_recordings_are_noise_of_known_size(tmp_path: Path) -> None:
    recording(tmp_path / "a.c3d", 600, 3)
    found = read_recording([tmp_path / "a.c3d"], labels(3), second_opinion=False)
    assert found.position_mm.shape == (3, 3, 72_000)
    assert np.diff(found.position_mm[1, 0]).std() / np.sqrt(2) == pytest.approx(0.007, rel=0.02)


def test_costs_of_a_rule_are_summed_and_its_memory_is_the_largest(tmp_path: Path) -> None:
    folder = tmp_path / "benchmarks/clean"
    folder.mkdir(parents=True)
    for name, line in {"a": "1.5\t300", "b": "2.5\t1200", "c": "-\t-"}.items():
        (folder / f"{name}.tsv").write_text(f"cpu_time\tmax_rss\n{line}\n")
    assert costs(tmp_path) == {"clean": (4.0, 1.2)}


def test_costs_of_a_size_replace_those_before(tmp_path: Path) -> None:
    """As the figure reads them: with the sum of the seconds."""
    path = tmp_path / "scale.csv"
    store(path, "hours", 9, {"noise": (40.0, 0.5), "gone": (1.0, 0.1)})
    store(path, "markers", 9, {"noise": (7.0, 0.25)})
    store(path, "hours", 0.5, {"noise": (4.0, 0.375)})
    store(path, "hours", 9, {"noise": (20.0, 0.5), "verdict": (30.0, 1.25)})
    found = measured(path)
    assert list(found["hours"]) == [0.5, 9.0]
    assert found["hours"][9.0] == {
        "cpu_s": {"noise": 20.0, "verdict": 30.0, "all jobs": 50.0},
        "gb": {"noise": 0.5, "verdict": 1.25},
    }
    assert found["markers"][9.0]["gb"] == {"noise": 0.25}
