"""bar.json, bar.csv and bar_places.csv of a bar, and what is said of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict

import numpy as np

from mocap_metrology.accuracy.bar import LEAST_SEEN, STATISTICS, Bar, OfClass
from mocap_metrology.accuracy.clusters import ScaleSlope
from mocap_metrology.accuracy.components import FEWEST, Repeated
from mocap_metrology.accuracy.findings import Finding
from mocap_metrology.common.types import Row
from mocap_metrology.noise.motion.place import LEAST_DIFFERENCES, by_place
from mocap_metrology.present.tables import Record
from mocap_metrology.present.text.numbers import ARITHMETIC, significant
from mocap_metrology.present.text.sentence import render
from mocap_metrology.settings import Bar as Settings

PLACES = (  # columns of bar_places.csv; sigma_mm: of one frame
    *("class", "x_mm", "y_mm", "z_mm", "n_frames", "error_mm", "sigma_mm", "lower_mm", "upper_mm"),
)
NOT_COVERED = ("latency", "places outside those covered", "changes after the last pass")


def bar_document(
    bar: Bar,
    findings: Sequence[Finding],
    settings: Settings,
    pair: Sequence[str],
    scale: ScaleSlope | None = None,
    clusters: Sequence[Record] = (),
    warnings: Sequence[str] = (),
) -> Row:
    """Contents of bar.json; clusters: `labels`, `spread_mm`, `n_frames` of the rigid ones found."""
    certificate = bar.certificate
    document: Row = {
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
        "scale": _scale(scale),
        "clusters": list(clusters),
        "findings": [one.as_dict() for one in findings],
        "not_covered": list(NOT_COVERED),
    }
    document["reason"] = reason(document)
    document["sentences"] = sentences(document)
    little = [render("bar.seen", seen=bar.seen)] if bar.seen < LEAST_SEEN else []
    document["warnings"] = [*warnings, *little]
    return document


def _class(one: OfClass) -> Row:
    return {
        "class": one.name,
        "passes": list(one.passes),
        "n_frames": one.n_frames,
        "n_eff": one.n_eff,
        "statistics_mm": {name: asdict(value) for name, value in one.statistics.items()},
        "parts_mm": {
            name: {"name": name, "value": size.value, "lower": size.lower, "upper": size.upper}
            for name, size in one.parts.sizes.items()
        },
        "place_share": one.parts.place_share,
    }


def _scale(scale: ScaleSlope | None) -> Row | None:
    if scale is None:
        return None
    own: Row = {"slope_ppm_m": scale.slope, "se": scale.se, "between": scale.between}
    own |= {"lower_95": scale.lower, "upper_95": scale.upper}
    return own | {"pairs": len(scale.pairs), "way_m": scale.way_m}


def reason(document: Record) -> str:
    """The sentence of the word."""
    worst = next(c for c in document["classes"] if c["class"] == document["worst"])
    numbers = {"p95": worst["statistics_mm"]["p95"]["value"], "one": len(document["classes"]) == 1}
    return render("bar.precise" if document["certificate"] is None else "bar.accuracy",
                  **{**document, **numbers})  # fmt: skip


def sentences(document: Record) -> list[str]:
    """What follows from a bar beside its word: the mean and the scale, findings, what else would be
    needed."""
    said = []
    if document["certificate"]:
        said += [render("bar.mean", c=c, **document["certificate"]) for c in document["classes"]]
    of_class = {one["class"]: len(one["passes"]) for one in document["classes"]}
    said += [
        render(f"bar.{one['code']}", **one, passes=of_class.get(one["series"], 0), fewest=FEWEST)
        for one in document["findings"]
    ]
    passes = min(of_class.values())
    if document["scale"] and not any(f["code"] == "scale_slope" for f in document["findings"]):
        said.append(render("bar.no_slope", **document["scale"]))
    if document["certificate"] and not document["certificate"]["u_mm"]:
        said.append(render("bar.exact"))
    if passes < FEWEST:
        said.append(render("bar.few", passes=passes, fewest=FEWEST))
    return said


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
        found = statistics[key]
        row |= {key: found.value, f"{key}_lower": found.lower, f"{key}_upper": found.upper}
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
        cells = by_place(middle, error, cell_mm, least=least)
        found = ({"class": one.name, "error_mm": c["deviation_mm"] + mean, **c} for c in cells)
        rows += [{column: row[column] for column in PLACES} for row in found]
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


def told(documents: Sequence[Record]) -> list[str]:
    """Word, reason, sentences and warnings of some bars, each with its markers where they are
    several."""
    said = []
    for one in documents:
        name = f" on {' and '.join(one['pair'])}" if len(documents) > 1 else ""
        said += [f"Verdict{name}: {one['word']}. {one['reason']}", *one["sentences"]]
        said += [f"Warning: {words}." for words in one["warnings"]]
    return said


def bar_lines(document: Record) -> list[str]:
    """What `check --bar` prints."""
    rows = [["", "passes", "frames", "n_eff", *STATISTICS]]
    for one in document["classes"]:
        values = (one["statistics_mm"][name]["value"] for name in STATISTICS)
        sizes = [significant(v if abs(v) > ARITHMETIC["mm"] else 0.0) for v in values]
        counts = [len(one["passes"]), one["n_frames"], f"{one['n_eff']:.0f}"]
        rows.append([one["class"], *map(str, counts), *sizes])
    width = [max(map(len, column)) for column in zip(*rows, strict=True)]
    table = [f"  {'  '.join(map(str.ljust, row, width))}".rstrip() for row in rows]
    against = "certificate" if document["certificate"] else "mean"
    pair = " and ".join(document["pair"])
    length = f"{against}, {document['reference_mm']:.6g} mm"
    head = f"Error of the length of {pair} against its {length}, in mm:"
    found = [render("bar.cluster", **one) for one in document["clusters"]]
    return [
        f"{document['recording']}: {document['word']}",
        document["reason"],
        *document["sentences"],
        *found,
        "",
        head,
        *table,
        "",
        f"Not covered: {', '.join(document['not_covered'])}.",
        *(f"warning: {words}" for words in document["warnings"]),
    ]
