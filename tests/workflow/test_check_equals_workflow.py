"""The command for one file and the workflow compute the same numbers: every one that both write."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import yaml
from mocap_workflow.calibration_twins import calibration_twin
from running import write_sheet

from mocap_metrology.calibration.sweeps import write_board
from mocap_metrology.common.files import read_table
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.lighthouse.simulate.recording import simulate, write_dump

# The file as it was given, and whether ezc3d was asked: the workflow asks before, in its check
APART = ("source", "path", "second_opinion")


def leaves(value: object, key: str = "") -> Iterator[tuple[str, object]]:
    """Every number and word of a JSON document by its place."""
    if isinstance(value, dict):
        for name, item in value.items():
            yield from leaves(item, f"{key}.{name}") if name not in APART else ()
    elif isinstance(value, list):
        for number, item in enumerate(value):
            yield from leaves(item, f"{key}.{number}")
    else:
        yield key, value


def contents(path: Path) -> object:
    """What a file holds, comparable with `==`."""
    if path.suffix == ".parquet":
        columns, origin = read_table(path)
        return {k: v.tobytes() if v.dtype != object else list(v) for k, v in columns.items()}, dict(
            leaves(origin)
        )
    text = path.read_text(encoding="utf-8")
    return (
        dict(leaves(json.loads(text)))
        if text.startswith(("{", "["))
        else list(csv.reader(text.splitlines()))
    )


def check(folder: Path, *arguments: str) -> None:
    command = [sys.executable, "-m", "mocap_metrology", "check", *arguments]
    subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=900)


def assert_same(own: Path, of_workflow: Path, fewest: int) -> None:
    """Files that the command writes, but for figures and a table for other programs, are those of
    the workflow."""
    others = (".png", ".svg")
    names = {p.name for p in own.iterdir() if p.suffix not in others} - {"allan.csv"}
    assert len(names) >= fewest
    for name in names:
        assert contents(own / name) == contents(of_workflow / name), name


def test_a_recording(tmp_path: Path, root: Path, snakemake: Callable) -> None:
    """Two markers with white noise, a slow wave, outliers, a gap and a jump."""
    n, rng = 4000, np.random.default_rng(8)
    position = rng.normal(0, 0.02, (n, 2, 3))
    position += [[100, 200, 300], [400, 250, 900]]
    position[:, 0, 2] += 0.05 * np.sin(2 * np.pi * 1.3 * np.arange(n) / 50)
    position[rng.integers(0, n, 12), 1, 0] += 1.0
    position[1500:1530, 1] = np.nan
    write_c3d(tmp_path / "take.c3d", ["A", "B"], 50.0, [position], n)
    row = {"recording": "take", "path": "take.c3d", "markers": "A;B", "group": "check"}
    sheet, out = tmp_path / write_sheet(tmp_path, list(row), row), tmp_path / "results"
    own = out / "recordings/take"
    options = (f"recordings={sheet}", "calibrations=", f"results={out}")
    asked = [str(own / name) for name in ("verdict.json", "adev.png")]
    options += ("noise={estimators: [likelihood]}", "fit_figures=[]")
    done = snakemake(root, "--cores", "2", *asked, "--config", *options)
    assert done.returncode == 0, done.stdout
    check(tmp_path, "take.c3d", "--markers", "A", "B", "--output", "one")
    assert_same(tmp_path / "one", own, 13)
    for name in ("verdict", "adev", "trajectory", "diagnosis"):
        for kind in ("svg", "png"):
            file = f"{name}.{kind}"
            assert (tmp_path / "one" / file).read_bytes() == (own / file).read_bytes(), file


def test_a_dump(tmp_path: Path, root: Path, snakemake: Callable) -> None:
    """One second of a simulated board before two stations, by the estimators that the command uses;
    the paper's are for its tables."""
    twin = calibration_twin(yaml.safe_load((root / "config/twins.yaml").read_text()), "sim-1-1")
    made = simulate(twin.model_copy(update={"duration_s": 1.0}), 7)
    write_dump(tmp_path / "dump.bin", made.pulses)
    write_board(str(tmp_path / "board.csv"), made.truth.board)
    row = {"calibration": "dump", "setup": "one", "group": "check", "path": "dump.bin"}
    row |= {"format": "gpio-dump", "board": "board.csv"}
    sheet, out = tmp_path / write_sheet(tmp_path, list(row), row), tmp_path / "results"
    own = out / "calibrations/dump"
    options = ("recordings=", f"calibrations={sheet}", f"results={out}")
    options += ("lighthouse={estimators: [batch, paper-lm]}",)
    asked = str(own / "calibration.png")
    done = snakemake(root, "--cores", "2", asked, "--config", *options)
    assert done.returncode == 0, done.stdout
    check(tmp_path, "dump.bin", "--board", "board.csv", "--output", "one")
    assert_same(tmp_path / "one", own, 12)
    for name in ("calibration.svg", "track.svg"):
        assert (tmp_path / "one" / name).read_bytes() == (own / name).read_bytes(), name
