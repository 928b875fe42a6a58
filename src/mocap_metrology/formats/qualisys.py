"""Qualisys TSV: motion data exported from Track Manager with its header.

Layout after the QTM manual, "Motion data (.tsv)": a name and its values a line (NO_OF_FRAMES,
FREQUENCY, DATA_INCLUDED, MARKER_NAMES, ...); then, as the export was set, a line of column names;
then frame and time in s where they were asked for, and three coordinates a label in mm. A gap is
empty, NULL or three zeros, as the export was set.
"""

from __future__ import annotations

import re
from pathlib import Path

from mocap_metrology.common.errors import Refusal
from mocap_metrology.formats.head import Line, check_text, lines
from mocap_metrology.formats.layout import Layout, count, named, number, rate, triples
from mocap_metrology.formats.rows import NULLS

WHAT = "a Qualisys export (TSV with its header)"
FIELD = re.compile(r"[A-Z][A-Z0-9_]{2,}")


def layout(path: Path) -> Layout:
    """Read the header of a Qualisys TSV file; refuses what is none or contradicts itself."""
    check_text(path, WHAT)
    fields, titles, first = _header(path)
    labels = _labels(fields, path.name)
    leading = _leading(titles, first, len(labels), path.name)
    declared = count(fields["NO_OF_FRAMES"][0], "NO_OF_FRAMES", path.name)
    return Layout(
        path=path,
        format="Qualisys text",
        labels=labels,
        columns=triples(len(leading), len(labels)),
        frame_rate_hz=rate(fields.get("FREQUENCY", [""])[0]),
        units="mm",
        mm_per_unit=1.0,
        delimiter="\t",
        data_line=first.number,
        data_offset=first.start,
        n_columns=len(leading) + 3 * len(labels),
        frame_column=leading.index("frame") if "frame" in leading else None,
        time_column=leading.index("time") if "time" in leading else None,
        declared=("NO_OF_FRAMES", declared),
        zero_is_gap=True,
    )


def _header(path: Path) -> tuple[dict[str, list[str]], list[str], Line]:
    """Fields with their values, names of columns (or none), the first line of numbers."""
    fields: dict[str, list[str]] = {}
    titles: list[str] = []
    for line in lines(path):
        cells = line.cells("\t")
        filled = [cell for cell in cells if cell]
        if not fields and (not filled or not FIELD.fullmatch(filled[0])):
            break
        if not line.text.strip("\r\n "):
            continue
        measured = bool(filled) and (number(filled[0]) is not None or filled[0] in NULLS)
        named_field = filled and not measured and FIELD.fullmatch(cells[0])
        if named_field and not titles and cells[0] not in fields:
            fields[cells[0]] = [*cells[1:], ""]
        elif filled and cells[0] in fields:  # EVENT, one line each
            continue
        elif not titles and filled and not measured:
            titles = cells
        elif "NO_OF_FRAMES" in fields:
            return fields, titles, line
        else:
            break
    if "NO_OF_FRAMES" in fields:
        raise Refusal(f"{path.name}: has no frames: nothing follows the header")
    raise Refusal(f"{path.name}: is not {WHAT}: it has no line NO_OF_FRAMES before its numbers")


def _labels(fields: dict[str, list[str]], file: str) -> tuple[str, ...]:
    included = fields.get("DATA_INCLUDED", ["3D"])[0]
    if included.upper() != "3D":
        raise Refusal(f"{file}: DATA_INCLUDED is {included[:40]!r}, expected 3D")
    labels = list(fields.get("MARKER_NAMES", []))
    while labels and not labels[-1]:
        labels.pop()
    if not labels:
        raise Refusal(f"{file}: MARKER_NAMES is missing or empty, so no marker has a label")
    if "NO_OF_MARKERS" in fields:
        n = count(fields["NO_OF_MARKERS"][0], "NO_OF_MARKERS", file)
        if n != len(labels):
            raise Refusal(f"{file}: MARKER_NAMES are {len(labels)}, NO_OF_MARKERS says {n}")
    return named(labels)


def _leading(titles: list[str], first: Line, n: int, file: str) -> list[str]:
    """What stands before the coordinates: nothing, `frame`, `time`, or both."""
    leading = [title.lower() for title in titles[:2] if title.lower() in ("frame", "time")]
    if leading:
        return leading
    cells = first.cells("\t")
    empty = next((i for i, cell in enumerate(reversed(cells)) if cell), len(cells))
    extra = len(cells) - (empty % 3 == 1) - 3 * n  # a tab may end each line
    if extra not in (0, 1, 2):
        raise Refusal(
            f"{file}: line {first.number} has {len(cells)} cells, expected {3 * n} for {n} markers,"
            " and frame and time before them or not"
        )
    whole = "." not in cells[0] and "," not in cells[0]
    return [[], ["frame"] if whole else ["time"], ["frame", "time"]][extra]
