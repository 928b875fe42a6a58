"""A recording from its file to the verdict in one process."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from mocap_metrology.common.files import Metadata, write_csv
from mocap_metrology.common.types import Row
from mocap_metrology.io.recording import Recording
from mocap_metrology.recording import figures
from mocap_metrology.recording.clean import Check, Entry, clean
from mocap_metrology.recording.noise import noise
from mocap_metrology.recording.progress import Progress
from mocap_metrology.recording.verdict import diagnose, verdict
from mocap_metrology.settings import Settings

N_STEPS = 7  # lines of progress
GROUP = "check"  # of a recording without a sheet
PICTURES = ("verdict", "adev", "trajectory", "diagnosis")
FILES = (
    *("check.json", "trajectories.parquet", "clean.parquet", "outliers.csv"),
    *("allan.parquet", "psd.parquet", "gaussian.csv", "covariance.csv"),
    *("noise.csv", "allan.csv", "allan_masked.parquet", "periodogram.parquet", "verdict.json"),
    *("noise_ros.yaml", "px4.params"),
    *("diagnosis.json", "events.csv", "periodic.csv", "filters.csv"),
    *(f"{figure}.{kind}" for figure in PICTURES for kind in ("svg", "png")),
)


def origin(name: str, pairs: Sequence[tuple[str, str]] | None = None) -> Metadata:
    """What tables of a measured recording are marked with; pairs: of labels, the first two unless
    given."""
    record: Metadata = {"recording": name, "source": "measured", "twin": None}
    return record | ({"pairs": pairs} if pairs else {})


def analyse(
    entry: Entry,
    name: str,
    folder: Path,
    settings: Settings,
    tell: Callable[[Check, Recording], None],
    progress: Progress,
    group: str = GROUP,
    pairs: Sequence[tuple[str, str]] | None = None,
) -> Mapping[str, Any]:
    """All steps of one measured recording, with its figures; contents of verdict.json.

    A thread runs the steps, those of `progress` work on the series, and this one draws meanwhile:
    matplotlib is for one thread only.
    """
    named: Row = {"recording": name, "group": group}
    named |= {"twin": None, "camera_type": "", "n_cameras": None}
    thread = ThreadPoolExecutor(1)
    try:
        results = clean(entry, origin(name, pairs), settings, folder, tell=tell, progress=progress)
        fitted = thread.submit(noise, results, settings, progress=progress)
        diagnosis = thread.submit(diagnose, results, settings, progress)
        document = thread.submit(verdict, results, named, settings, progress)
        figures.draw_trajectory(results)
        fitted.result()
        figures.draw_allan(results)
        write_csv(folder / "allan.csv", results.allan_masked.rows())
        figures.draw_diagnosis(diagnosis.result(), results, settings)
        document.result()
        progress.step("figures")
        figures.draw_verdict(document.result(), results)
    finally:
        thread.shutdown(wait=False, cancel_futures=True)
        progress.end()
    return document.result()
