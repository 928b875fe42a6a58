"""Intermediate files that are damaged on the disk: named, removed, made again by a plain run."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from running import write_sheet

from mocap_metrology.io.c3d.write import write_c3d

HEADER = ["recording", "path", "markers", "group"]
OWN = "results/recordings/lab/"
MADE = [f"{OWN}{name}" for name in ("allan.parquet", "psd.parquet")]

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


def test_a_damaged_table_and_a_damaged_check_are_made_again(
    tmp_path: Path, root: Path, snakemake
) -> None:
    """The check at once: Snakemake reads it for its plan."""
    noise = np.random.default_rng(1).normal([0, 0, 0, 400, 0, 0], 0.1, (900, 6))
    write_c3d(tmp_path / "a.c3d", ["A", "B"], 100.0, [noise.reshape(-1, 2, 3)], 900)
    write_sheet(
        tmp_path, HEADER, {"recording": "lab", "path": "a.c3d", "markers": "A;B", "group": "g"}
    )
    settings = ("--config", "recordings=sheet.tsv", "calibrations=", "results=results", QUICK)
    where = ("--directory", str(tmp_path), "--cores", "2", *settings, "--", *MADE)
    first = snakemake(root, *where, drawn="")
    assert first.returncode == 0, first.stdout
    expected = contents(tmp_path)

    table, check = (f"{OWN}{name}" for name in ("trajectories.parquet", "check.json"))
    damage(tmp_path / table)
    for name in MADE:
        (tmp_path / name).unlink()
    failed = snakemake(root, *where, drawn="")
    assert failed.returncode == 1
    lines = [line for line in failed.stdout.splitlines() if f" lab: {table} is damaged: " in line]
    assert any(line.endswith("make it anew") for line in lines), failed.stdout
    assert not (tmp_path / table).exists()

    (tmp_path / check).write_bytes((tmp_path / check).read_bytes()[:-20])
    again = snakemake(root, *where, check, drawn="")
    assert again.returncode == 0, again.stdout
    assert "check.json is damaged: its content is not what was written" in again.stdout
    assert contents(tmp_path) == expected
