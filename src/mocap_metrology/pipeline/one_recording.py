"""A recording from its file to the verdict in one process: the steps that rules do one by one."""

from __future__ import annotations

import json
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, cast

from mocap_metrology.common.files import write_csv, write_json
from mocap_metrology.common.types import Row
from mocap_metrology.noise.assess.recording import OutlierRow
from mocap_metrology.noise.fit.estimates import NoiseRow
from mocap_metrology.noise.motion.movement import Movement
from mocap_metrology.pipeline import figures, judging
from mocap_metrology.pipeline.checking import Examined
from mocap_metrology.pipeline.judging import Diagnosed
from mocap_metrology.pipeline.progress import Progress
from mocap_metrology.pipeline.reading import trajectories
from mocap_metrology.pipeline.recording import (
    Cleaned,
    NoiseTables,
    allan_deviations,
    cleaned,
    noise_coefficients,
)
from mocap_metrology.pipeline.statistics import spectra
from mocap_metrology.pipeline.tables import Table
from mocap_metrology.present.tables import read_noise, read_outliers
from mocap_metrology.settings import Settings

N_STEPS = 7
GROUP = "check"  # of a recording without a sheet
PICTURES = ("verdict", "adev", "psd", "trajectory", "diagnosis")
WRITTEN = (  # besides check.json
    *("trajectories.parquet", "clean.parquet", "outliers.csv", "allan.parquet", "psd.parquet"),
    *("noise.csv", "allan_masked.parquet", "periodogram.parquet", "verdict.json"),
    *("diagnosis.json", "events.csv", "periodic.csv", "filters.csv"),
    *(f"{figure}.{kind}" for figure in PICTURES for kind in ("svg", "png")),
)


def analyse(
    given: Examined,
    name: str,
    folder: Path,
    settings: Settings,
    progress: Progress,
) -> Mapping[str, Any]:
    """Write the results of a measured recording into `folder`; return verdict.json's contents.

    A thread runs the steps, those of `progress` work on the series, and this one draws meanwhile:
    matplotlib is for one thread only.
    """
    steps = _Steps(given, name, folder, settings, progress)
    thread = ThreadPoolExecutor(1)
    try:
        clean = thread.submit(steps.clean)
        psd = thread.submit(steps.spectra)
        noise = thread.submit(steps.noise)
        diagnosed = thread.submit(steps.diagnose)
        verdict = thread.submit(steps.judge)
        figures.draw_trajectory(*clean.result(), folder / "trajectory")
        figures.draw_psd(psd.result(), folder / "psd")
        figures.draw_allan(noise.result().allan, folder / "adev")
        found, origin, false_alarm = diagnosed.result(), steps.raw.origin, steps.limits.false_alarm
        figures.draw_diagnosis(found, origin, false_alarm, folder / "diagnosis")
        document = verdict.result()
        progress.step("figures")
        figures.draw_verdict(document, folder / "verdict")
    finally:
        thread.shutdown(wait=False, cancel_futures=True)
        progress.end()
    return document


class _Steps:
    """The steps of a recording in their order; each computes from what those before it left here.

    Small tables are read again from their files, as the rules do: so the digits are the same.
    """

    raw: Table
    filtered: Cleaned
    psd: Table
    found: NoiseTables
    rows: list[NoiseRow]

    def __init__(
        self,
        given: Examined,
        name: str,
        folder: Path,
        settings: Settings,
        progress: Progress,
    ):
        self.given, self.name = given, name
        self.folder, self.settings, self.progress = folder, settings, progress
        still, horizon_s = settings.still, settings.verdict.horizon_s
        self.limits = judging.diagnosis_settings(settings.diagnosis, still, horizon_s)

    def clean(self) -> tuple[Table, Table]:
        """Coordinates as recorded, and all series cleaned."""
        self.progress.step("gap-filled frames and outliers")
        over, named = self.progress.over, {"recording": self.name, "source": "measured"}
        self.raw = trajectories(self.given.recording, named | {"twin": None}, over=over)
        self.progress.later(self.raw.write, self.folder / "trajectories.parquet")
        self.filtered = cleaned(self.raw, self.settings.hampel, over)
        self.progress.later(self.filtered.table.write, self.folder / "clean.parquet")
        write_csv(self.folder / "outliers.csv", self.filtered.report)
        return self.raw, self.filtered.table

    def spectra(self) -> Table:
        self.progress.step("power spectral densities")
        clean = self.filtered.table
        self.psd = spectra(clean.in_mm(), clean.origin, self.settings.psd, self.progress.over)
        self.psd.write(self.folder / "psd.parquet")
        return self.psd

    def noise(self) -> NoiseTables:
        """Allan deviations, and the model of the noise."""
        over, settings, clean = self.progress.over, self.settings, self.filtered.table
        self.progress.step("Allan deviations")
        allan = allan_deviations(clean.in_mm(), clean.origin, settings.allan, over)
        allan.write(self.folder / "allan.parquet")
        self.progress.step("noise model")
        outliers = self.filtered.outliers
        self.found = noise_coefficients(
            self.raw, allan.columns, settings, over=over, outliers=outliers
        )
        write_csv(self.folder / "noise.csv", self.found.rows)
        self.found.allan.write(self.folder / "allan_masked.parquet")
        self.found.periodogram.write(self.folder / "periodogram.parquet")
        return self.found

    def diagnose(self) -> Diagnosed:
        self.progress.step("events, periodic disturbances, filters")
        # Written above, so of these columns
        self.rows = cast(list[NoiseRow], read_noise(self.folder / "noise.csv"))
        how = self.limits, self.progress.over, self._movements()
        found = judging.diagnosed(self.raw, self.psd, self.rows, *how)
        found.write(self.folder, self.name, "measured")
        return found

    def _movements(self) -> dict[str, Movement]:
        """Of the coordinates that are as they were when they were examined."""
        found, filled = self.given.movements, self.raw.origin["n_filled_frames"]
        return {
            f"{axis}{number}": movement
            for number, label in enumerate(self.raw.origin["labels"], start=1)
            for axis, movement in found[label].items()
            if not filled[label]
        }

    def judge(self) -> Row:
        self.progress.step("verdict")
        clean, outliers = self.filtered.table, read_outliers(self.folder / "outliers.csv")
        evidence = judging.Evidence(
            clean.in_mm(),
            clean.origin,
            self.found.allan.columns,
            self.rows,
            cast(list[OutlierRow], outliers),  # written above, as well
            json.loads((self.folder / "diagnosis.json").read_text(encoding="utf-8")),
            self.given.check["warnings"],
        )
        named: Row = {"recording": self.name, "group": GROUP}
        named |= {"twin": None, "camera_type": "", "n_cameras": None}
        how = self.settings.verdict, self.settings.allan.confidence, self.progress.over
        document = judging.judged(evidence, named, *how)
        write_json(self.folder / "verdict.json", document)
        return document
