"""`mocap-metrology monitor FOLDER take.c3d`: one take more of a facility, and what it says."""

from __future__ import annotations

import argparse
import csv
import io
import re
import shutil
import sys
import uuid
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any, cast

from mocap_metrology.cli import recording as of_recording
from mocap_metrology.cli import results
from mocap_metrology.common import sheets
from mocap_metrology.common.documents import load_yaml
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.faults import Faults, quoted
from mocap_metrology.common.files import sha256
from mocap_metrology.common.paths import exists, expanded, is_file, locked
from mocap_metrology.common.sheets import Line, parts_of
from mocap_metrology.common.spreadsheet import number
from mocap_metrology.io.labels import pair_of
from mocap_metrology.io.recording import Recording
from mocap_metrology.io.units import Unit
from mocap_metrology.recording import analyse
from mocap_metrology.recording.clean import Check, Entry, clean
from mocap_metrology.recording.monitor import monitor, read_take, unfit, write_take
from mocap_metrology.recording.monitor_sheet import monitors
from mocap_metrology.recording.progress import ProgressLines
from mocap_metrology.recording.results import Results
from mocap_metrology.settings import Noise, Settings, checked

SHEET, CONFIG, RESULTS = "recordings.tsv", "config.yaml", "results"
COLUMNS = ("recording", "path", "markers", "group", "date", "monitor", "baseline")
# Of a row, what the next take does not share
OWN = ("recording", "path", "date", "baseline", "sha256", "truncated", "compare_with", "covariate")
STATUS = {"alert": 3, "failure": 4}


def add_take(options: argparse.Namespace) -> int:
    """Exit status of the command: 0, of an alert 3, of a failure 4."""
    of_recording.reuse_freed_memory()
    folder, path = (expanded(text) for text in (options.folder, options.file))
    if not is_file(path):
        what = "is not a file" if exists(path) else "no such file"
        raise Refusal(f"{path}: {what}; expected a take, as take.c3d")
    try:
        with _exclusive_folder(folder):
            document = _add_take(Sheet(folder), path, options, _settings(folder))
    except OSError as error:
        why = f"{error.filename or folder}: {error.strerror or error}"
        raise Refusal(f"{why}; the take was not added, and nothing changed") from None
    name = document["monitor"]
    chart = folder / RESULTS / "monitors" / name / "chart.png"
    results.tell_result([document["line"], f"Chart: {chart}"])
    return STATUS.get(str(document["word"]), 0)


def _settings(folder: Path) -> Settings:
    """Settings of config.yaml in the folder, where there is one; defaults for the others."""
    defaults = Settings(noise=Noise(estimators=("likelihood",)))
    try:
        raw = (folder / CONFIG).read_bytes()
    except FileNotFoundError:
        return defaults
    try:
        settings = checked(load_yaml(raw.decode("utf-8")) or {}, whole=False)
    except Faults as faults:
        raise Refusal("; ".join(f"{folder / CONFIG}: {line}" for line in faults.lines)) from None
    except ValueError as error:
        raise Refusal(f"{folder / CONFIG}: no readable YAML: {error}") from None
    return settings.model_copy(update={"noise": defaults.noise})


class Sheet:
    """recordings.tsv of the folder as text and as rows; without one it is empty."""

    def __init__(self, folder: Path):
        self.folder, self.path = folder, folder / SHEET
        self.raw = self.path.read_bytes() if self.path.exists() else b""
        self.lines: list[Line] = []
        if self.raw:
            self.lines = sheets.read(self.path, COLUMNS, ["recording", "path"], others=True)

    def of(self, name: str) -> list[Line]:
        """Rows of a monitor."""
        return [line for line in self.lines if line.cells["monitor"] == name]

    def located(self, line: Line) -> list[str]:
        """Files of a row, as seen from the working folder."""
        return [str(self.folder / part) for part in parts_of(line.cells["path"])]

    def expect_without(self, path: Path) -> None:
        """Refuse a file that a row names."""
        for line in self.lines:
            if path.name not in line.cells["path"]:  # a link of another name has the same checksum
                continue
            if path.resolve() in [Path(one).resolve() for one in self.located(line)]:
                raise Refusal(
                    f"{path}: is the file of row {line.number} (recording "
                    f'"{line.cells["recording"]}"); expected a take that is not in the sheet yet'
                )

    def new_name(self, name: str, date: str) -> str:
        """The name of a recording that no row has: with the date, and a number, where needed."""
        names = {line.cells["recording"].casefold() for line in self.lines}
        if name.casefold() not in names:
            return name
        stem = unique = f"{name}-{re.sub('[^0-9]', '', date)}"
        count = 2
        while unique.casefold() in names:
            unique, count = f"{stem}-{count}", count + 1
        return unique

    def with_row(self, cells: Mapping[str, str]) -> bytes:
        """The sheet and one row more, as its editor wrote it: columns that it lacks are added to
        its header."""
        text = sheets.decoded(self.raw)
        end = "\r\n" if "\r\n" in text else "\n"
        rows = text.splitlines()
        is_header = [sheets.has_cells(row) for row in rows]
        at = is_header.index(True) if any(is_header) else len(rows)
        delimiter = sheets.delimiter(rows[at], COLUMNS) if any(is_header) else "\t"
        header = next(csv.reader(rows[at : at + 1], delimiter=delimiter), [])
        header = [sheets.column_named(name.strip(), COLUMNS) for name in header]
        while header and not header[-1]:
            header.pop()
        header += [name for name in cells if name not in header and cells[name]]
        rows[at : at + 1] = [_joined(header, delimiter)]
        rows.append(_joined([cells.get(name, "") for name in header], delimiter))
        return (end.join(rows) + end).encode("utf-8")


def _joined(cells: Sequence[str], delimiter: str) -> str:
    text = io.StringIO()
    csv.writer(text, delimiter=delimiter, lineterminator="").writerow(cells)
    return text.getvalue()


def _add_take(
    sheet: Sheet, path: Path, options: argparse.Namespace, settings: Settings
) -> Mapping[str, Any]:
    """Adds the take to the sheet, its results and those of the monitor to the folder: all or
    nothing; contents of monitor.json."""
    line = _line(sheet, path, options)
    name, recording = line.cells["monitor"], line.cells["recording"]
    rows = monitors(str(sheet.path), [*sheet.lines, line])[name]
    takes = _earlier_take(sheet, name, settings)
    first = {tuple(one["sha256"]): name for name, one in takes.items() if one["sha256"]}
    if why := unfit({"recording": recording, "sha256": [sha256(path)], "moving": False}, first):
        raise Refusal(f"{path}: {why}; expected a take that is not in the sheet yet")
    folder = sheet.folder / RESULTS
    with _part(folder) as part:
        of_take, of_monitor = part / "recordings" / recording, part / "monitors" / name
        of_take.mkdir(parents=True)
        (part / SHEET).write_bytes(sheet.with_row(line.cells))
        takes[recording] = _analysed(sheet, line, of_take, settings)
        document = monitor(name, rows, takes, settings, of_monitor)
        for one in document["left_out"]:
            if one["recording"] == recording:
                raise Refusal(f"{path}: {one['why']}")
        if sheet.path.exists() and sheet.path.read_bytes() != sheet.raw:
            raise Refusal(f"{sheet.path} was changed meanwhile; run the command again")
        store = folder / "monitors" / name
        store.mkdir(parents=True, exist_ok=True)
        _moved(of_take, folder / "recordings" / recording)
        for file in of_monitor.iterdir():
            file.replace(store / file.name)
        (part / SHEET).replace(sheet.path)
    return document


@contextmanager
def _exclusive_folder(folder: Path) -> Iterator[None]:
    """Waits until no other command adds to the folder; one that is made for it and stays empty
    goes again."""
    new = [one for one in (folder / RESULTS, folder) if not one.exists()]
    try:
        with locked(folder):
            yield
    finally:
        for one in new:
            with suppress(OSError):  # is not empty
                one.rmdir()


@contextmanager
def _part(folder: Path) -> Iterator[Path]:
    """A folder to work in, which is removed in the end."""
    for other in folder.glob(f"{results.PART}*"):  # of a killed command: there is one at a time
        shutil.rmtree(other, ignore_errors=True)
    part = folder / f"{results.PART}{uuid.uuid4().hex[:12]}"
    try:
        part.mkdir(parents=True)
        yield part
    finally:
        shutil.rmtree(part, ignore_errors=True)


def _moved(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    if target.exists():
        shutil.rmtree(target)
    source.replace(target)


def _line(sheet: Sheet, path: Path, options: argparse.Namespace) -> Line:
    """The row of the new take: what it shares with the last one of its monitor, and its own."""
    watched = [line for line in sheet.lines if line.cells["monitor"]]
    name = options.monitor or (watched[-1].cells["monitor"] if watched else "")
    name = name or results.name_of(sheet.folder.resolve())
    before = sheet.of(name)
    last = before[-1].cells if before else {"group": name}
    cells = {key: cell for key, cell in last.items() if key not in (*OWN, "comment")}
    date = options.date or datetime.fromtimestamp(path.stat().st_mtime).isoformat()[:16]
    tomorrow = str(datetime.now().date() + timedelta(days=1))
    if re.match(r"\d{4}-", date) and date[:10] > tomorrow:  # no later take could follow
        raise Refusal(f"{path}: its date is {date}, in the future; expected today or earlier")
    if options.markers:
        cells["markers"] = ";".join(options.markers)
    elif not cells.get("markers"):
        entry = Entry([str(path)], [], options.rate, unit=options.unit)
        markers, why = of_recording.chosen(entry, Settings().still.range_mm, sys.maxsize)
        results.tell(f"Markers: {', '.join(markers)} ({why}); name others with --markers")
        cells["markers"] = ";".join(markers)
    for key, value in (("frame_rate_hz", options.rate), ("unit", options.unit)):
        if value:
            cells[key] = str(value)
    sheet.expect_without(path)
    beside = path.resolve()
    if beside.is_relative_to(sheet.folder.resolve()):
        beside = beside.relative_to(sheet.folder.resolve())
    cell = beside.as_posix()
    if parts_of(cell) != (cell,) or cell.splitlines() != [cell]:
        raise Refusal(f"{path}: no cell of a sheet can hold its name; rename it")
    baseline = "restart" if options.restart else ""
    cells |= {"recording": sheet.new_name(results.name_of(path), date), "path": cell}
    cells |= {"date": date, "monitor": name, "baseline": baseline}
    row = sheet.raw.count(b"\n") + 1 if sheet.raw else 2
    return Line(row, dict.fromkeys(COLUMNS, "") | cells)


def _entry(sheet: Sheet, line: Line) -> tuple[Entry, list[tuple[str, str]] | None]:
    """What a row states of its recording, and its pairs."""
    cells = line.cells
    markers = [marker for marker in parts_of(cells["markers"]) if marker]
    rate = cells.get("frame_rate_hz", "")
    try:
        hz = number(rate.replace(",", ".")) if rate else None
    except ValueError:
        cell = f"{sheet.path}, row {line.number}, column frame_rate_hz: {quoted(rate)}"
        raise Refusal(f"{cell}; expected frames a second, as 100") from None
    entry = Entry(
        sheet.located(line),
        markers,
        hz,
        cells.get("truncated") == "accept",
        cast(Unit | None, cells.get("unit") or None),  # others are refused where a file is read
        column_names=cells.get("column_names") or None,
    )
    where = f"{sheet.path}, row {line.number}", "two markers of the row", "column pairs"
    texts = filter(None, parts_of(cells.get("pairs", "")))
    return entry, [pair_of(text, markers, *where) for text in texts] or None


def _earlier_take(sheet: Sheet, name: str, settings: Settings) -> dict[str, Mapping[str, Any]]:
    """monitor_take.json of the takes of a monitor; made where it is missing, or is of other files,
    other markers or another wander. Without those that cannot be read."""
    takes, recordings = {}, sheet.folder / RESULTS / "recordings"
    for line in sheet.of(name):
        recording = line.cells["recording"]
        folder = f"{recordings}/{recording}"
        try:
            earlier = read_take(folder)
            is_current = tuple(earlier["take"]["jitters_mm"]) == parts_of(line.cells["markers"])
            is_current &= earlier["wander_s"] == settings.monitor.wander_s
            named = [Path(part).name for part in parts_of(line.cells["path"])]
            is_current &= earlier["files"] == sorted(named)
        except (OSError, ValueError, KeyError):
            is_current = False
        try:
            takes[recording] = (
                earlier if is_current else _made_again(sheet, line, Path(folder), settings)
            )
        except Refusal as refusal:
            results.tell(f"{recording}: {refusal}")
    return takes


def _made_again(sheet: Sheet, line: Line, folder: Path, settings: Settings) -> Mapping[str, Any]:
    recording = line.cells["recording"]
    missing = [path for path in sheet.located(line) if not Path(path).is_file()]
    if missing:
        raise Refusal(f"{missing[0]}: no such file; expected the take of row {line.number}")
    results.tell(f"{recording}: reading again")
    with results.replaced(folder, ()) as part:
        entry, pairs = _entry(sheet, line)
        return write_take(clean(entry, analyse.origin(recording, pairs), settings, part), settings)


def _analysed(sheet: Sheet, line: Line, folder: Path, settings: Settings) -> Mapping[str, Any]:
    """Results of the new take in the folder; contents of its monitor_take.json."""
    entry, pairs = _entry(sheet, line)
    name = line.cells["recording"]

    def tell(check: Check, recording: Recording) -> None:
        of_recording.tell(check, recording)
        if why := unfit({"recording": name, "sha256": [], "moving": check.get("moving")}, {}):
            raise Refusal(f"{Path(entry.paths[0]).name}: {why}")

    progress = ProgressLines(sys.stderr, analyse.N_STEPS, of_recording.processors())
    group = line.cells["group"]
    analyse.analyse(entry, name, folder, settings, tell, progress, group, pairs)
    return write_take(Results(folder), settings)
