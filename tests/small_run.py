"""A run in miniature of every kind of input: short twins, a C3D file, calibrations."""

import csv
import hashlib
from pathlib import Path

import numpy as np
from mocap_workflow.calibration_twins import calibration_twin

from mocap_metrology.common.entries import load_twins
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.lighthouse.simulate.recording import simulate

ROOT = Path(__file__).resolve().parents[1]
RECORDINGS = """\
group	recording	path	markers	camera_type	n_cameras
skurowski2019	T40-10	simulate:T40-10		T40	10
skurowski2019	T40-2	simulate:T40-2		T40	2
lab	measured	take.c3d	A;B
"""
CALIBRATIONS = """\
group	setup	calibration	path	format	board
jansen2019	sim-1	sim-1-1	simulate:sim-1-1	gpio-dump
lab	room	angles	angles.csv	angles-csv	board.csv
"""
SETTINGS = ("recordings=recordings.tsv", "calibrations=calibrations.tsv", "results=results")
OF_EACH_RUN = ("logs", "benchmarks", "report.html", "provenance.html", "provenance.json")


def write_inputs(folder: Path) -> Path:
    """Write the sheets and the files they name; returns the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "recordings.tsv").write_text(RECORDINGS, encoding="utf-8")
    (folder / "calibrations.tsv").write_text(CALIBRATIONS, encoding="utf-8")
    frames = np.array([[100.0, 200.0, 1000.0], [400.0, 200.0, 1000.0]])
    frames = frames + np.random.default_rng(1).normal(scale=0.05, size=(3000, 2, 3))
    write_c3d(folder / "take.c3d", ["A", "B"], 120.0, [frames.astype(np.float32)], 3000)
    write_angles(folder)
    return folder


def write_angles(folder: Path) -> None:
    """Angles of a simulated calibration and its board, as a user's own decoder would write them."""
    twin = calibration_twin(load_twins(str(ROOT / "config/twins.yaml")), "sim-1-1")
    made = simulate(twin, seed=5)
    names = ("station", "axis", "cycle", "diode", "time_s", "angle_rad")
    columns = [getattr(made.hits, name).tolist() for name in names]
    for file, header, rows in (
        ("angles.csv", names, zip(*columns, strict=True)),
        ("board.csv", ("x_m", "y_m", "z_m"), made.truth.board.tolist()),
    ):
        with (folder / file).open("w", newline="", encoding="utf-8") as stream:
            csv.writer(stream).writerows([header, *rows])


def arguments(root: Path = ROOT) -> list[str]:
    """What Snakemake is called with in such a folder: a checkout's workflow, quick settings."""
    return [
        *("--snakefile", str(root / "Snakefile"), "--configfile", str(root / "config/quick.yaml")),
        *("--config", *SETTINGS, "duration_s=60"),
    ]


def digests(results: Path, at_least: int = 5) -> dict[str, str]:
    """SHA-256 of every result by its path, except what no two runs have in common."""
    found = {
        path.relative_to(results).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(results.rglob("*"))
        if path.is_file() and path.relative_to(results).parts[0] not in OF_EACH_RUN
    }
    assert len(found) >= at_least, f"{results}: {len(found)} files"
    return found


def differences(one: Path, other: Path) -> list[str]:
    """A line for each result that is missing in one of two folders or differs between them."""
    first, second = digests(one), digests(other)
    return [
        f"{name}: {'differs' if name in first and name in second else 'is missing in one'}"
        for name in sorted(first.keys() | second.keys())
        if first.get(name) != second.get(name)
    ]
