"""Intermediate files that are damaged on the disk: named, removed, made again by a plain run."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from running import write_sheet

from mocap_metrology.io.c3d.write import write_c3d

HEADER = ["recording", "path", "markers", "group"]
OWN = "results/recordings/lab/"
TABLE = "results/tables/g_outliers.csv"
MADE = [f"{OWN}{name}" for name in ("allan.parquet", "psd.parquet", "gaussian.csv")]

QUICK = "noise={estimators: [likelihood]}"


def contents(folder: Path) -> dict[str, bytes]:
    """All files of the recording, without leftovers of any kind."""
    return {path.name: path.read_bytes() for path in (folder / OWN).iterdir() if path.is_file()}


def damage(path: Path) -> None:
    """Turn one bit of the values, and leave the times of the file."""
    times = path.stat()
    raw = bytearray(path.read_bytes())
    raw[len(raw) // 3] ^= 4
    path.write_bytes(raw)
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


@pytest.fixture(scope="module")
def run_once(tmp_path_factory: pytest.TempPathFactory, root: Path, snakemake) -> Path:
    """Folder of a recording with a table of its group."""
    folder = tmp_path_factory.mktemp("computed")
    noise = np.random.default_rng(1).normal([0, 0, 0, 400, 0, 0], 0.1, (900, 6))
    write_c3d(folder / "a.c3d", ["A", "B"], 100.0, [noise.reshape(-1, 2, 3)], 900)
    row = {"recording": "lab", "path": "a.c3d", "markers": "A;B", "group": "g"}
    write_sheet(folder, HEADER, row)
    first = runner(folder, root, snakemake)(TABLE)
    assert first.returncode == 0, first.stdout
    return folder


def runner(folder: Path, root: Path, snakemake):
    """A call that makes the results, and others that it is given."""
    settings = ("--config", "recordings=sheet.tsv", "calibrations=", "results=results", QUICK)

    def run(*arguments: str, options: tuple[str, ...] = ()):
        where = ("--directory", str(folder), "--cores", "2", *options, *settings)
        return snakemake(root, *where, "--", *MADE, *arguments, drawn="")

    return run


@pytest.fixture
def computed(tmp_path: Path, run_once: Path, root: Path, snakemake):
    """The recording in a folder of the test's own, with dates and checksums of its results: a call
    that makes them, and what they are."""
    shutil.copytree(run_once, tmp_path, dirs_exist_ok=True, symlinks=True)
    return runner(tmp_path, root, snakemake), contents(tmp_path)


def test_a_damaged_table_is_made_again(tmp_path: Path, computed) -> None:
    run, expected = computed
    damage(tmp_path / OWN / "trajectories.parquet")
    for name in ("allan.parquet", "psd.parquet"):
        (tmp_path / OWN / name).unlink()
    failed = run()
    assert failed.returncode == 1
    lines = [line for line in failed.stdout.splitlines() if "trajectories.parquet" in line]
    where = f"{OWN}trajectories.parquet"
    found = f" lab: {where} is damaged: "
    assert any(found in line and line.endswith("make it anew") for line in lines), failed.stdout
    assert not (tmp_path / where).exists()
    again = run()
    assert again.returncode == 0, again.stdout
    assert contents(tmp_path) == expected


def test_a_damaged_text_and_a_damaged_check_are_made_again(tmp_path: Path, computed) -> None:
    """The check at once: Snakemake reads it for its plan."""
    run, expected = computed
    path, check = tmp_path / OWN / "gaussian.csv", tmp_path / OWN / "check.json"
    path.write_text("\n".join(path.read_text().splitlines()[:-1]))
    (tmp_path / TABLE).unlink()
    failed = run(TABLE)
    assert failed.returncode == 1
    assert f": {OWN}gaussian.csv is damaged: " in failed.stdout
    assert not path.exists()
    check.write_bytes(check.read_bytes()[:-20])
    plan = run(TABLE, options=("-n",))  # clears nothing
    assert plan.returncode == 1
    assert f"{OWN}check.json is damaged; the next run makes it anew" in plan.stdout
    assert check.exists()
    again = run(f"{OWN}check.json", TABLE)
    assert again.returncode == 0, again.stdout
    assert "check.json is damaged: its content is not what was written" in again.stdout
    assert contents(tmp_path) == expected
