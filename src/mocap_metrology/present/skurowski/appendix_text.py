"""Tables A1-A3 of S to read: panels (a) x1 ... (g) L as in the paper, and h_0 of every series."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mocap_metrology.noise.fit.estimates import (
    DEFAULT_ESTIMATOR,
    PLAIN_ESTIMATOR,
    S_ESTIMATOR,
    unit_key,
)
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.published import COEFFICIENTS, SERIES
from mocap_metrology.present.skurowski.appendix import (
    UNPAIRED,
    notes_by_coefficient,
    support_counts,
)
from mocap_metrology.present.tables import Record, Row, aligned
from mocap_metrology.present.text.numbers import MARKS, STATUS_SIGNS, duration_words, significant

UNSUPPORTED, LEFT_OUT = "†", "‡"
SIGNS = (
    f"Lines for each number of cameras: published, {S_ESTIMATOR}, {PLAIN_ESTIMATOR} if it was "
    f"run, {DEFAULT_ESTIMATOR}. {UNSUPPORTED} {{length}} cannot support the number (least "
    f"standard error above the number itself); {LEFT_OUT} corrected, omitted or to be read with "
    f"care: see the notes below; {STATUS_SIGNS}; < not detected, upper 95 % limit; – no partner. "
    "Empty: no such estimate."
)


def table_a_markdown(
    rows: Sequence[Row], title: str, caption: str, duration_s: float | None = None
) -> str:
    """Markdown of the rows of one `table_a`: a panel a series, full digits are in the CSV.

    duration_s: length of the recordings, where it is known.
    """
    length = "this length" if duration_s is None else duration_words(duration_s)
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
        return f"Which numbers {length} can support was not computed."
    left = f", {total['not_computed']} have no bound" if total["not_computed"] else ""
    return (
        f"{length[:1].upper()}{length[1:]} cannot support {total['unsupported']} of the "
        f"{total['published']} published numbers{left}."
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
    return significant(row["published"]) + sign + (LEFT_OUT if _own_notes(row) else "")


def _own_notes(row: Row) -> list[str]:
    """The remark on this published number."""
    notes, _ = notes_by_coefficient(row["camera_type"], row["n_cameras"])
    return notes.get((row["series"], row["parameter"]), [])


def _estimated(row: Row | None, column: str) -> str:
    if row is None:
        return ""
    status = row[f"{column}_status"]
    if status == "not_detected":
        upper = row.get(f"{column}_upper_95")
        return f"< {significant(upper)}" if upper is not None else "not detected"
    if status == UNPAIRED:
        return "–"
    return significant(row[column]) + MARKS.get(status, "") if row[column] is not None else ""


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
            place.append(f"{name} {significant(value)} {row['unit']}")
    lines += [
        f"- {n} cameras, {who}, not published: {', '.join(v)}" for (n, who), v in groups.items()
    ]
    return lines


NEAR = 0.05  # what counts as the same white level
BOUNDS = 3.0  # or so many Cramer-Rao bounds, where they are wider
CAPTION = (
    "h_0 in mm²/Hz. expected: S's estimator (annealing-ant-colony, continuous-time formulas) on "
    "the exact Allan variances of the published model; regenerated: the same on the recording; "
    "likelihood: this project's default. Columns in per cent are deviations: of expected and "
    "likelihood from the published value (likelihood may deviate by likelihood_allowed_percent: "
    "5 %, or three Cramer-Rao bounds), of regenerated from expected. expected deviates where "
    "components of other kinds replace the white noise at hardly more cost, and for point "
    "samples where the formulas do not hold. regenerated deviates from expected by chance and "
    "because the 3-sigma filter replaces samples."
)


def white_levels(rows: Sequence[Record]) -> list[Row]:
    """One row a published series, from the rows of `appendix.table_a`."""
    made = []
    for row in rows:
        if row["parameter"] != "h_0" or row["published"] is None:
            continue
        published = row["published"]
        relative = row["crlb_relative"]
        allowed = max(NEAR, BOUNDS * relative) if relative is not None else NEAR
        off = _percent(row["likelihood"], published)
        made.append(
            {k: row[k] for k in ("camera_type", "n_cameras", "series", "published", "expected")}
            | {"expected_percent": _percent(row["expected"], published)}
            | {"regenerated": row["regenerated"]}
            | {"regenerated_percent": _percent(row["regenerated"], row["expected"])}
            | {"likelihood": row["likelihood"], "likelihood_percent": off}
            | {"likelihood_allowed_percent": 100 * allowed}
            | {k: row[k] for k in ("source", "recording")}
        )
    return made


def summary(rows: Sequence[Row]) -> str:
    """The counts a reader looks for, in one sentence each."""
    known = [row for row in rows if row["recording"]]
    expected = _count(known, "expected_percent", 100 * NEAR)
    regenerated = _count(known, "regenerated_percent", 100 * NEAR)
    beyond = [
        f"{row['camera_type']}-{row['n_cameras']} {row['series']}"
        for row in known
        if not abs(_number(row["likelihood_percent"])) <= row["likelihood_allowed_percent"]
    ]
    listed = f" ({', '.join(beyond)})" if beyond else ""
    return (
        f"Of {len(known)} series, expected deviates by more than 5 % in {expected}, regenerated "
        f"deviates from expected by more than 5 % in {regenerated}, and likelihood deviates by "
        f"more than 5 % and {BOUNDS:g} bounds in {len(beyond)}{listed}."
    )


def _count(rows: Sequence[Row], column: str, limit: float) -> int:
    return sum(not abs(_number(row[column])) <= limit for row in rows)


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _percent(value: float | None, reference: float | None) -> float | None:
    if value is None or reference is None or not reference > 0 or math.isnan(value):
        return None
    return 100 * (value / reference - 1)
