"""A recording from its file to the verdict in one process: the steps that rules do one by one."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, cast

import pandas as pd

from mocap_metrology.common.files import write_csv, write_json
from mocap_metrology.common.types import Row
from mocap_metrology.io.recording import Recording
from mocap_metrology.noise.assess.recording import OutlierRow
from mocap_metrology.noise.fit.estimates import NoiseRow
from mocap_metrology.noise.fit.estimators import NoiseSections
from mocap_metrology.pipeline import figures, judging
from mocap_metrology.pipeline.progress import Progress
from mocap_metrology.pipeline.reading import trajectories
from mocap_metrology.pipeline.recording import (
    allan_deviations,
    cleaned,
    noise_coefficients,
    spectra,
)
from mocap_metrology.pipeline.settings import Settings
from mocap_metrology.present.tables import read_noise

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
    take: Recording,
    warnings: list[str],
    name: str,
    folder: Path,
    settings: Settings,
    progress: Progress,
) -> Mapping[str, Any]:
    """Write the results of a measured recording into `folder`; return verdict.json's contents.

    warnings: of check.json. Small tables are read again from their files, as the rules do, so that
    both compute with the same digits.
    """
    over = progress.over
    progress.step("gap-filled frames and outliers")
    raw = trajectories(take, {"recording": name, "source": "measured", "twin": None})
    raw.write(folder / "trajectories.parquet")
    filtered = cleaned(raw, settings.hampel, over)
    clean = filtered.table
    clean.write(folder / "clean.parquet")
    write_csv(folder / "outliers.csv", filtered.report)

    progress.step("Allan deviations")
    allan = allan_deviations(clean.in_mm(), clean.origin, settings.allan, over)
    allan.write(folder / "allan.parquet")
    progress.step("power spectral densities")
    psd = spectra(clean.in_mm(), clean.origin, settings.psd, over)
    psd.write(folder / "psd.parquet")

    progress.step("noise model")
    sections, outliers = noise_sections(settings), filtered.outliers
    noise = noise_coefficients(raw, allan.columns, sections, over=over, outliers=outliers)
    write_csv(folder / "noise.csv", noise.rows)
    noise.allan.write(folder / "allan_masked.parquet")
    noise.periodogram.write(folder / "periodogram.parquet")
    # Tables that were written above, so of these columns
    rows = cast(list[NoiseRow], read_noise(folder / "noise.csv"))
    counted = cast(list[OutlierRow], pd.read_csv(folder / "outliers.csv").to_dict("records"))

    progress.step("events, periodic disturbances, filters")
    limits = judging.diagnosis_settings(
        settings.diagnosis, settings.still, settings.verdict.horizon_s
    )
    diagnosed = judging.diagnosed(raw, psd, rows, limits, over)
    diagnosed.write(folder, name, "measured")

    progress.step("verdict")
    evidence = judging.Evidence(
        clean.in_mm(),
        clean.origin,
        noise.allan.columns,
        rows,
        counted,
        json.loads((folder / "diagnosis.json").read_text(encoding="utf-8")),
        warnings,
    )
    named: Row = {
        "recording": name,
        "group": GROUP,
        "twin": None,
        "camera_type": "",
        "n_cameras": None,
    }
    found = judging.judged(evidence, named, settings.verdict, settings.allan.confidence)
    write_json(folder / "verdict.json", found)

    progress.step("figures")
    figures.draw_verdict(found, folder / "verdict")
    figures.draw_allan(noise.allan, folder / "adev")
    figures.draw_psd(psd, folder / "psd")
    figures.draw_diagnosis(diagnosed, raw.origin, limits.false_alarm, folder / "diagnosis")
    figures.draw_trajectory(raw, clean, folder / "trajectory")
    progress.end()
    return found


def noise_sections(settings: Settings) -> NoiseSections:
    """What `noise_coefficients` takes of the settings."""
    return {
        "noise": asdict(settings.noise),
        "annealing": asdict(settings.annealing),
        "allan": asdict(settings.allan),
        "hampel": asdict(settings.hampel),
        "seed": settings.seed,
    }
