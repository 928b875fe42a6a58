"""Numbers of bar.json, rows of bar.csv and bar_places.csv, and the noise of a length at rest."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict

import numpy as np

from mocap_metrology.accuracy.bar import STATISTICS, Bar, OfClass
from mocap_metrology.accuracy.clusters import ScaleSlope
from mocap_metrology.accuracy.findings import Finding
from mocap_metrology.accuracy.statistics import Repeated
from mocap_metrology.common.types import Record, Row
from mocap_metrology.noise.motion.place import LEAST_DIFFERENCES, by_place
from mocap_metrology.settings import Bar as Settings

NOT_COVERED = (
    "a delay of both ends alike",
    "places outside those covered",
    "changes after the last pass",
)
PLACES = (  # columns of bar_places.csv; sigma_mm: of one frame
    *("class", "x_mm", "y_mm", "z_mm", "n_frames", "error_mm", "sigma_mm", "lower_mm", "upper_mm"),
)


def bar_rows(bar: Bar) -> list[Row]:
    """bar.csv: a row a class, all of them, and the angles."""
    every = [*bar.classes, *([bar.every] if len(bar.classes) > 1 else [])]
    rows = [_row("length_mm", one.name, len(one.passes), one.n_frames, one.n_eff, one.statistics)
            for one in every]  # fmt: skip
    if bar.angles:
        n = sum(int(np.isfinite(t.angle_deg).sum()) for t in bar.takes if t.angle_deg is not None)
        rows.append(_row("angle_deg", "all", bar.angles["mean"].k, n, None, bar.angles))
    return rows


def _row(
    quantity: str,
    name: str,
    passes: int,
    frames: int,
    n_eff: float | None,
    statistics: Mapping[str, Repeated],
) -> Row:
    row: Row = {"quantity": quantity, "class": name, "passes": passes, "frames": frames}
    row["n_eff"] = n_eff
    for key in STATISTICS:
        number = statistics[key]
        row |= {key: number.value, f"{key}_lower": number.lower, f"{key}_upper": number.upper}
    return row


def place_rows(bar: Bar, cell_mm: float, least: int = LEAST_DIFFERENCES) -> list[Row]:
    """bar_places.csv: the mean error of each class in cubes of `cell_mm` with `least` pairs of
    successive frames in them."""
    rows: list[Row] = []
    for one in bar.classes:
        gap = np.full(1, np.nan)
        error = np.concatenate([part for e in one.errors for part in (e, gap)])
        middle = [np.concatenate([part for m in one.middles for part in (m[k], gap)])
                  for k in range(3)]  # fmt: skip
        mean = float(np.nanmean(error))
        cells, _ = by_place(middle, error, cell_mm, least=least)
        every = ({"class": one.name, "error_mm": c["deviation_mm"] + mean, **c} for c in cells)
        rows += [{column: row[column] for column in PLACES} for row in every]
    return rows


def noise_at_rest(verdicts: Iterable[Record]) -> float | None:
    """Median standard deviation of a length at rest, of contents of verdict.json; None of no
    recording at rest with a length."""
    known = [
        verdict["series"]["L"]["frame_mm"]
        for verdict in verdicts
        if "bar" not in verdict
        and verdict["decided_by"]["code"] != "moves"
        and "L" in verdict["series"]
    ]
    sizes = [size for size in known if size is not None]
    return float(np.median(sizes)) if sizes else None


def bar_numbers(
    bar: Bar,
    findings: Sequence[Finding],
    settings: Settings,
    pair: Sequence[str],
    scale: ScaleSlope | None = None,
    clusters: Sequence[Record] = (),
) -> Row:
    """Numbers of bar.json; clusters: `labels`, `spread_mm`, `n_frames` of the rigid ones found."""
    certificate, slope = bar.certificate, None
    if scale is not None:
        slope = {"slope_ppm_m": scale.slope, "se": scale.se, "between": scale.between}
        slope |= {"lower_95": scale.lower, "upper_95": scale.upper}
        slope |= {"pairs": len(scale.pairs), "way_m": scale.way_m}
    return {
        "word": bar.word(settings),
        "size_mm": bar.size_mm,
        "rms_mm": bar.rms_mm,
        "limits_mm": {"good": settings.good_mm, "usable": settings.usable_mm},
        "pair": list(pair),
        "certificate": asdict(certificate) if certificate else None,
        "reference_mm": bar.reference_mm,
        "passes": [take.name for take in bar.takes],
        "seen": bar.seen,
        "worst": bar.worst.name,
        "classes": [_class(one) for one in bar.classes],
        "angles_deg": {name: asdict(one) for name, one in bar.angles.items()},
        "between_classes": asdict(bar.direction) if bar.direction else None,
        "scale": slope,
        "clusters": list(clusters),
        "findings": [one.as_dict() for one in findings],
        "not_covered": list(NOT_COVERED),
    }


def _class(one: OfClass) -> Row:
    return {
        "class": one.name,
        "passes": list(one.passes),
        "pass_means_mm": [float(np.nanmean(e)) for e in one.errors],
        "n_frames": one.n_frames,
        "n_eff": one.n_eff,
        "statistics_mm": {name: asdict(value) for name, value in one.statistics.items()},
        "parts_mm": {
            name: {"name": name, "value": size.value, "lower": size.lower, "upper": size.upper}
            for name, size in one.parts.sizes.items()
        },
        "place_share": one.parts.place_share,
    }
