"""Intermediate files that are damaged on the disk: named, removed, made again by a plain run."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from running import write_sheet

from mocap_metrology.io.c3d.write import write_c3d

HEADER = ["recording", "path", "markers", "group"]
OWN = "results/recordings/lab/"
MADE = [f"{OWN}{name}" for name in ("allan.parquet", "psd.parquet", "gaussian.csv")]


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


@pytest.fixture
def computed(tmp_path: Path, root: Path, snakemake):
    """A recording with a few results, a call that makes them, and what they are."""
    noise = np.random.default_rng(1).normal([0, 0, 0, 400, 0, 0], 0.1, (3000, 6))
    write_c3d(tmp_path / "a.c3d", ["A", "B"], 100.0, [noise.reshape(-1, 2, 3)], 3000)
    row = {"recording": "lab", "path": "a.c3d", "markers": "A;B", "group": "g"}
    sheet = write_sheet(tmp_path, HEADER, row)
    settings = ("--config", f"recordings={sheet}", "calibrations=", "results=results")

    def run(*arguments: str):
        where = ("--directory", str(tmp_path), "--cores", "2", *settings)
        return snakemake(root, *where, "--", *MADE, *arguments)

    first = run()
    assert first.returncode == 0, first.stdout
    return run, contents(tmp_path)


def test_a_damaged_table_is_made_again(tmp_path: Path, computed) -> None:
    run, expected = computed
    damage(tmp_path / OWN / "clean.parquet")
    for name in ("allan.parquet", "psd.parquet"):
        (tmp_path / OWN / name).unlink()
    failed = run()
    assert failed.returncode == 1
    lines = [line for line in failed.stdout.splitlines() if "clean.parquet" in line]
    where = f"{OWN}clean.parquet"
    found = f" lab: {where} is damaged: "
    assert any(found in line and line.endswith("make it anew") for line in lines), failed.stdout
    assert not (tmp_path / where).exists()
    again = run()
    assert again.returncode == 0, again.stdout
    assert contents(tmp_path) == expected
    assert "Nothing to be done" in run().stdout


def test_a_damaged_check_is_made_again(tmp_path: Path, computed) -> None:
    """At once: Snakemake reads it for its plan."""
    run, expected = computed
    path = tmp_path / OWN / "check.json"
    path.write_bytes(path.read_bytes()[:-20])
    again = run(f"{OWN}check.json")
    assert again.returncode == 0, again.stdout
    assert "check.json is damaged: its content is not what was written" in again.stdout
    assert contents(tmp_path) == expected


def test_a_damaged_text_is_made_again(tmp_path: Path, computed) -> None:
    run, expected = computed
    path = tmp_path / OWN / "outliers.csv"
    path.write_text("\n".join(path.read_text().splitlines()[:-1]))
    verdict = f"{OWN}verdict.json"
    failed = run(verdict)
    assert failed.returncode == 1
    assert f"verdict lab: {OWN}outliers.csv is damaged: " in failed.stdout
    assert not path.exists()
    again = run(verdict)
    assert again.returncode == 0, again.stdout
    assert {name: contents(tmp_path)[name] for name in expected} == expected
