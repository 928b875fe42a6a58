"""Takes of monitored facilities in a sheet of recordings, in its order."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime

from mocap_metrology.accuracy.monitor_row import Row
from mocap_metrology.common.entries import NAME
from mocap_metrology.common.faults import Faults, quoted
from mocap_metrology.common.sheets import Line, parts_of

# What takes share from one restart to the next
ALIKE = ("markers", "pairs", "camera_type", "n_cameras", "camera_ids")


def monitors(sheet: str, lines: Sequence[Line]) -> dict[str, list[Row]]:
    """Takes by monitor, in order of the rows. `Faults` names rows without a date or out of order,
    of other markers, pairs or cameras than the take before, names that are no folder's, stand
    twice or have other capitals, and a baseline without a monitor."""
    takes: dict[str, list[Row]] = {}
    before: dict[str, Line] = {}
    names: dict[str, int] = {}
    spelt: dict[str, str] = {}
    faults = []
    for line in lines:
        cells = line.cells
        name, baseline, date = (cells.get(key, "") for key in ("monitor", "baseline", "date"))

        def wrong(column: str, expected: str, of: Line = line) -> str:
            where = f'{sheet}, row {of.number} (recording "{of.cells["recording"]}")'
            return f"{where}, column {column}: {quoted(of.cells.get(column))}; expected {expected}"

        if not name:
            if baseline:
                faults.append(wrong("baseline", "nothing, as column monitor is empty"))
            continue
        faults += [
            wrong(column, "letters, digits and _ - . alone, first a letter or digit")
            for column in ("recording", "monitor")  # folders of results
            if not NAME.fullmatch(cells[column])
        ]
        known = spelt.setdefault(name.casefold(), name)
        if known != name:
            faults.append(wrong("monitor", f"{known}, as in the rows before, or another name"))
        number = names.setdefault(cells["recording"].casefold(), line.number)
        if number != line.number:
            faults.append(wrong("recording", f"another name than row {number}"))
        day = _moment(date)
        if day is None:
            what = "the date of a take that is monitored, such as 2026-03-02 or 2026-03-02T08:15"
            faults.append(wrong("date", what))
            continue
        last = before.get(name)
        if last is not None:
            named = f"as row {last.number}, the take before of monitor {name}"
            if _is_before(date, last.cells["date"]):
                faults.append(wrong("date", f"{last.cells['date']} or later, {named}"))
            if baseline != "restart":
                faults += [
                    wrong(column, f"{quoted(last.cells.get(column))}, {named}; or restart")
                    for column in ALIKE
                    if parts_of(cells.get(column, "")) != parts_of(last.cells.get(column, ""))
                ]
        before[name] = line
        takes.setdefault(name, []).append(Row(cells["recording"], day, baseline))
    if faults:
        raise Faults(faults)
    return takes


def _is_before(date: str, other: str) -> bool:
    """Whether a moment is before another one: where both state a zone by the instant, else by the
    clock, to the day where one has no time."""
    moments = [datetime.fromisoformat(one.replace(" ", "T")) for one in (date, other)]
    if all(one.tzinfo for one in moments):
        return moments[0] < moments[1]
    texts = [_moment(one) or "" for one in (date, other)]
    n = min(map(len, texts))
    return texts[0][:n] < texts[1][:n]


def _moment(text: str) -> str | None:
    """A date, with or without a time, as ISO 8601 has it; None if it is none."""
    try:
        moment = datetime.fromisoformat(text.replace(" ", "T"))
    except ValueError:
        return None
    return moment.isoformat()[: 10 if re.fullmatch(r"[0-9-]{10}", text) else 19]
