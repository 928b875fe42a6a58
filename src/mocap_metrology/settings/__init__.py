"""Every setting of config.yaml: type, range, default and help. Functions get the sections."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, ValidationError

from mocap_metrology.common.faults import Faults, quoted
from mocap_metrology.common.sections import WHOLE, Section, Words, faults
from mocap_metrology.settings.lighthouse import JansenStudies, Lighthouse, PoseEstimator
from mocap_metrology.settings.recordings import (
    Allan,
    Annealing,
    Bar,
    Cameras,
    Compare,
    Diagnosis,
    Gaussian,
    Hampel,
    Monitor,
    Noise,
    Place,
    Scatter,
    Spectrum,
    Still,
    Tolerance,
    Verdict,
    Word,
)

__all__ = [
    "Allan",
    "Annealing",
    "Bar",
    "Cameras",
    "Compare",
    "Diagnosis",
    "Gaussian",
    "Hampel",
    "JansenStudies",
    "Lighthouse",
    "Monitor",
    "Noise",
    "Place",
    "PoseEstimator",
    "Scatter",
    "Settings",
    "Spectrum",
    "Still",
    "Tolerance",
    "Verdict",
    "Word",
    "checked",
]

Sheet = Annotated[str | None, Words("the path of a sheet, or nothing", "a path or nothing")]
SERIES = r"^([xyz][1-9][0-9]*|L|L_[1-9][0-9]*_[1-9][0-9]*)$"  # coordinate of a marker, distance


class Settings(Section):
    """config.yaml."""

    recordings: Sheet = "config/recordings.tsv"
    """Sheet of recordings. Nothing (`recordings=`) is an empty sheet."""
    calibrations: Sheet = "config/calibrations.tsv"
    """Sheet of Lighthouse calibrations."""
    twins: Annotated[
        str | None, Words("the path of a file of twins, or nothing", "a path or nothing")
    ] = "config/twins.yaml"
    """Simulated recordings and calibrations by name, with all their parameters."""
    results: Annotated[
        str,
        Field(pattern=r"^[^<>{}]*[^<>{}./][^<>{}]*$"),
        AfterValidator(os.path.normpath),
        Words(
            "a folder of its own, without any of < > { } "
            "(and not a name that reads as 1.5 or True)",
            "a folder",
        ),
    ] = "results"
    """Folder of all outputs. It is created if missing."""
    duration_s: float = Field(32400.0, ge=1)
    """Length of twin recordings, in s, unless a twin has a shorter one of its own. Nothing else
    depends on it."""
    seed: int = Field(2019, ge=0)
    """Added to the seed of every twin: another value simulates all recordings anew."""
    twin_form: Literal["continuous", "sampled"] = "continuous"
    """Meaning of a frame of a twin. `continuous`: an average over the frame period, whose Allan
    variance is that of the textbook formulas, in which the paper gives its coefficients. `sampled`:
    a point, as with cameras, whose exposure is far shorter than a frame. A twin with a `form` of
    its own is not affected (set `sampled` if its coefficients come from `likelihood` on a recording
    of a camera); subsets of a take are points."""
    hampel: Hampel = Hampel()
    allan: Allan = Allan()
    psd: Spectrum = Spectrum()
    still: Still = Still()
    verdict: Verdict = Verdict()
    compare: Compare = Compare()
    place: Place = Place()
    bar: Bar = Bar()
    monitor: Monitor = Monitor()
    cameras: Cameras = Cameras()
    fit_figures: Annotated[
        tuple[Annotated[str, Field(pattern=SERIES)], ...] | None,
        Words("nothing, or a list of series such as z1, L, L_1_3, or []", "a list of series"),
    ] = None
    """Series whose fits are drawn, `fit/<series>.svg`, where a recording has them. Nothing: the one
    that decided the verdict, and L. `snakemake results/recordings/<name>/fits` draws all."""
    png: bool = True
    """Whether the figures of the verdict, the diagnosis, the deviations, the trajectory and the
    fits are also saved as PNG. Pages show the SVG."""
    second_opinion: bool = True
    """Whether C3D files that are short enough are also read by ezc3d."""
    gaussian: Gaussian = Gaussian()
    diagnosis: Diagnosis = Diagnosis()
    noise: Noise = Noise()
    annealing: Annealing = Annealing()
    lighthouse: Lighthouse = Lighthouse()
    jansen_studies: JansenStudies = JansenStudies()


def checked(config: Mapping[str, object], whole: bool = True) -> Settings:
    """The configuration with every value of its type; `Faults` names all wrong ones. whole: whether
    every key must be there; otherwise those that are not have their defaults."""
    try:
        settings = Settings.model_validate(config, context=WHOLE if whole else None)
    except ValidationError as error:
        raise Faults(faults(error, Settings, config)) from None
    lines = []
    limits = {f"verdict.{key}": value for key, value in settings.verdict.model_dump().items()}
    drift = ("verdict.good_drift_mm", "verdict.usable_drift_mm")
    stated = any(limits[key] for key in drift)
    limits |= zip(drift, settings.verdict.drift_mm if stated else (0.0, 0.0), strict=True)
    limits |= {f"bar.{key}": value for key, value in settings.bar.model_dump().items()}
    for key, good in limits.items():
        other = key.replace("good_", "usable_")
        if other != key and other in limits and good > limits[other]:
            most = f"{other} ({limits[other]:g})"
            lines.append(f"config, key {key}: {quoted(good)}; expected at most {most}")
    if lines:
        raise Faults(lines)
    return settings
