"""Tables A1-A3 of S to read: panels (a) x1 ... (g) L as in the paper, in Markdown."""

from __future__ import annotations

from collections.abc import Sequence

from mocap_metrology.noise.fit.estimates import (
    DEFAULT_ESTIMATOR,
    PLAIN_ESTIMATOR,
    S_ESTIMATOR,
    unit_key,
)
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.published import COEFFICIENTS, SERIES
from mocap_metrology.present.numbers import MARKS, STATUS_SIGNS, duration_text, three_digits
from mocap_metrology.present.skurowski.appendix import (
    UNPAIRED,
    notes_by_coefficient,
    support_counts,
)
from mocap_metrology.present.tables import Row, aligned

UNSUPPORTED, LEFT_OUT = "†", "‡"
SIGNS = (
    f"The lines of a number of cameras: published, {S_ESTIMATOR}, {PLAIN_ESTIMATOR} if it was run, "
    f"{DEFAULT_ESTIMATOR}. "
    f"{UNSUPPORTED} {{length}} cannot support the number (least standard error above the number "
    f"itself); {LEFT_OUT} corrected, left out or to be read with care: see the notes below; "
    f"{STATUS_SIGNS}; < not detected, upper 95 % limit; – no partner. Empty: no such estimate."
)


def table_a_markdown(
    rows: Sequence[Row], title: str, caption: str, duration_s: float | None = None
) -> str:
    """Markdown of the rows of one `table_a`: a panel a series, full digits are in the CSV.

    duration_s: length of the recordings, where it is known.
    """
    length = "this length" if duration_s is None else duration_text(duration_s)
    length = f"a recording of {length}"
    lines = [f"# {title}", "", caption, "", SIGNS.format(length=length), ""]
    lines += [_count_sentence(rows, length), ""]
    for kind, n in dict.fromkeys((row["camera_type"], row["n_cameras"]) for row in rows):
        for note in notes_by_coefficient(kind, n)[1]:
            lines += [f"{n} cameras, all series: {note}.", ""]
    for letter, series in zip("abcdefg", SERIES, strict=True):
        panel = [row for row in rows if row["series"] == series]
        if panel:
            lines += [f"## ({letter}) {series}", "", *_panel(panel), ""]
            lines += [*_below(panel), ""]
    while lines[-1] == "":
        lines.pop()
    return "\n".join([*lines, ""])


def _count_sentence(rows: Sequence[Row], length: str) -> str:
    total = next((c for c in support_counts(rows) if c["parameter"] == "all"), None)
    if total is None or total["not_computed"] == total["published"]:
        return f"What {length} can support was not computed."
    left = f", {total['not_computed']} have no bound" if total["not_computed"] else ""
    return (
        f"Of {total['published']} published numbers {length} cannot support "
        f"{total['unsupported']}{left}."
    )


def _panel(rows: Sequence[Row]) -> list[str]:
    published = [row for row in rows if row["published"] is not None]
    names = [n for n in COEFFICIENTS if n in {row["parameter"] for row in published}]
    units = [NoiseModel.UNITS[unit_key(name)] for name in names]
    lines = [["cameras", "", *(f"{n} ({u})" for n, u in zip(names, units, strict=True))]]
    for n_cameras in dict.fromkeys(row["n_cameras"] for row in rows):
        cells = {row["parameter"]: row for row in published if row["n_cameras"] == n_cameras}
        ordered = [cells.get(name) for name in names]
        lines.append([str(n_cameras), "published", *(_published(row) for row in ordered)])
        for column, estimator in (
            ("regenerated", S_ESTIMATOR),
            ("plain", PLAIN_ESTIMATOR),
            (DEFAULT_ESTIMATOR, DEFAULT_ESTIMATOR),
        ):
            texts = [_estimated(row, column) for row in ordered]
            if any(texts):
                lines.append(["", estimator, *texts])
    return aligned(lines)


def _published(row: Row | None) -> str:
    if row is None:
        return ""
    sign = UNSUPPORTED if row["supported"] is False else ""
    return three_digits(row["published"]) + sign + (LEFT_OUT if _own_notes(row) else "")


def _own_notes(row: Row) -> list[str]:
    """What is said of this published number."""
    notes, _ = notes_by_coefficient(row["camera_type"], row["n_cameras"])
    return notes.get((row["series"], row["parameter"]), [])


def _estimated(row: Row | None, column: str) -> str:
    if row is None:
        return ""
    status = row[f"{column}_status"]
    if status == "not_detected":
        upper = row.get(f"{column}_upper_95")
        return f"< {three_digits(upper)}" if upper is not None else "not detected"
    if status == UNPAIRED:
        return "–"
    return three_digits(row[column]) + MARKS.get(status, "") if row[column] is not None else ""


def _below(rows: Sequence[Row]) -> list[str]:
    """Notes on published numbers, and the terms that were not published."""
    said: dict[tuple[int, str], list[str]] = {}
    for row in rows:
        if row["published"] is not None:
            for note in _own_notes(row):
                said.setdefault((row["n_cameras"], note), []).append(row["parameter"])
    lines = [
        f"- {n} cameras, {', '.join(names)}{LEFT_OUT}: {note}" for (n, note), names in said.items()
    ]
    groups: dict[tuple[int, str], list[str]] = {}
    for row in rows:
        if row["published"] is None:
            name, _, estimator = row["parameter"].partition(" (")
            value = next(
                row[k]
                for k in ("regenerated", "plain", "expected", DEFAULT_ESTIMATOR)
                if row[k] is not None
            )
            place = groups.setdefault((row["n_cameras"], estimator[:-1]), [])
            place.append(f"{name} {three_digits(value)} {row['unit']}")
    lines += [
        f"- {n} cameras, {who}, not published: {', '.join(v)}" for (n, who), v in groups.items()
    ]
    return lines
