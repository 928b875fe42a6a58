"""Recordings as laboratories make them, through files and all steps: what is said that is not so.

Two markers, 5 min at 50 Hz or as the kind has it, white noise of 0.02 mm a frame, in a C3D file.
`named`, `false`: as in `unforeseen`; a verdict `good` of a recording that is not is false too, and
so is a failure. Noise that is correlated over a third of a recording may be called a random walk.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.sentences import Row
from benchmarks.sentences._lab_kinds import KINDS
from benchmarks.sentences._waves import Kind, placed, rows_of
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.recording.analyse import origin
from mocap_metrology.recording.clean import Entry, clean
from mocap_metrology.recording.noise import noise
from mocap_metrology.recording.verdict import diagnose, verdict
from mocap_metrology.settings import Settings

SETTINGS = Settings(noise={"estimators": ("likelihood",)}, second_opinion=False)


def told(one: Kind, values: np.ndarray, folder: Path) -> set[str]:
    """Findings of (3 markers, n) values in mm, and `good` where the verdict must not be."""
    labels = [f"M{k + 1}" for k in range(one.markers)]
    frames = (placed(values) if one.placed else values).reshape(one.markers, 3, -1)
    path = folder / "take.c3d"
    write_c3d(path, labels, one.rate, [frames.transpose(2, 0, 1)], frames.shape[2], one.unit)
    results = clean(Entry([str(path)], labels), origin("take"), SETTINGS, folder)
    noise(results, SETTINGS)
    codes = {found.code for found in diagnose(results, SETTINGS).findings}
    word = verdict(results, {"recording": "take", "group": "check"}, SETTINGS)["word"]
    return codes | ({"good"} if word == "good" and not one.good else set())


def said_of(name: str, seed: int) -> set[str]:
    """Of one recording of a kind."""
    rng = np.random.default_rng([list(KINDS).index(name), seed, 11])
    values = KINDS[name].drawn(rng)
    with tempfile.TemporaryDirectory() as folder:
        try:
            return told(KINDS[name], values, Path(folder))
        except Exception as failure:
            return {f"{type(failure).__name__}: {failure}"}


def rows(runs: int) -> Iterator[Row]:
    """(case, statistic, runs, reach, measured)."""
    return rows_of(KINDS, said_of, runs)
