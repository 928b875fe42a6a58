"""Strict readers of every format but C3D: whatever is not consistent is unreadable.

They share nothing with the package, and read what the writers of the test files write.
"""

import csv
import io
import json
import math
import re
from collections.abc import Sequence
from typing import Any
from unicodedata import category

import numpy as np
import yaml

from .strict_c3d import MM, Unreadable, Values, need

DECIMAL = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
NONE = ("", "NULL", "null", "NaN", "nan", "NAN", "NA", "N/A", "None", "-nan")
LARGEST_CELL = 131_072
QUOTED = re.compile(r'(^|\t) *"((?:[^"\t\r\n]+|"")*)" *(?=[\t\r\n]|$)', re.M)  # cells of a sheet


def decoded(raw: bytes) -> str:
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def lines_of(raw: bytes) -> list[str]:
    need(not any(byte < 32 and byte not in b"\t\r\n" for byte in raw))
    lines = [line.rstrip("\r") for line in decoded(raw).split("\n")]
    need(all(len(cell) <= LARGEST_CELL for line in lines for cell in line.split(",")))
    need(not any("\r" in line for line in lines))
    return lines


def number(cell: str) -> float:
    cell = re.sub(r'^"([^"]*)"$', r"\1", cell.strip(" \t")).strip(" \t")
    if cell in NONE:
        return math.nan
    if re.fullmatch(r"[+-]?inf(inity)?", cell, re.I):
        return math.inf
    need(DECIMAL.fullmatch(cell))
    return float(cell)


def need_end(lines: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """The last number of a file that ends without a line end has no fewer decimals than all."""
    decimals = [len(cell.partition(".")[2]) for row in rows for cell in row if "." in cell]
    need(not lines[-1] or len(decimals) < 2 or decimals[-1] >= min(decimals[:-1]))


def whole(text: str) -> int:
    value = number(text)
    need(math.isfinite(value) and value == int(value))
    return int(value)


def series(
    rows: Sequence[Sequence[str]], labels: Sequence[str], every: Sequence[str], rate: float,
    mm: float | None, numbered: bool, timed: bool, zero: bool = False,
) -> Values:  # fmt: skip
    """Positions of the labels; rows begin with a frame number and a time where they have them."""
    need(rate > 0 and math.isfinite(rate) and len(rows) > 1)
    need(all(list(every).count(label) == 1 for label in labels))
    lead = numbered + timed
    width = lead + 3 * len(every)
    need(all(len(row) <= width + 100 for row in rows))
    need(all(not any(cell.strip() for cell in row[width:]) for row in rows))
    table = np.array([[number(cell) for cell in [*row, *[""] * width][:width]] for row in rows])
    index = np.arange(len(rows), dtype=float)
    if numbered:
        need(np.isfinite(table[:, 0]).all() and (table[:, 0] == np.round(table[:, 0])).all())
        index = table[:, 0] - table[0, 0]
    if timed:
        need(np.isfinite(table[:, lead - 1]).all())
        steps = np.diff(table[:, lead - 1]) * rate
        index = index if numbered else np.concatenate([[0], np.cumsum(np.round(steps))])
        need(abs(steps.sum() / index[-1] - 1) <= 1.027e-3)  # the rate, by the times
        need((np.abs(steps - np.diff(index)) < 0.51).all())
    need((np.diff(index) >= 1).all() and index[-1] < 11 * len(rows))
    xyz = np.full((len(labels), 3, int(index[-1]) + 1), np.nan)
    for k, label in enumerate(labels):
        at = lead + 3 * list(every).index(label)
        own = table[:, at : at + 3]
        missing = np.isnan(own).sum(axis=1)
        need(((missing == 0) | (missing == 3)).all())
        gone = ~np.isfinite(own).all(axis=1) | ((own == 0).all(axis=1) & zero)
        xyz[k][:, index.astype(int)] = np.where(gone[:, None], np.nan, own).T * (mm or 1.0)
    need(np.isfinite(xyz).all(axis=1).any(axis=1).all())
    return {"position_mm": xyz, "rate": rate, "unit_assumed": mm is None}


def unit_mm(text: str) -> float | None:
    known = MM | {"millimeters": 1.0, "centimeters": 10.0, "meters": 1000.0}
    need(not text.strip() or text.strip().lower() in known)
    return known.get(text.strip().lower())


def trc(raw: bytes, labels: Sequence[str]) -> Values:
    lines = lines_of(raw)
    need(len(lines) > 6 and lines[0].startswith("PathFileType"))
    names, values = ([c.strip() for c in line.strip().split("\t")] for line in lines[1:3])
    need(len(names) == len(values))
    said = dict(zip(names, values, strict=True))
    titles = [cell.strip() for cell in lines[3].split("\t")]
    need(titles[0].lower().startswith("frame") and titles[1].lower() == "time")
    n = whole(said.get("NumMarkers", ""))
    every = titles[2 : 2 + 3 * n : 3]
    need([cell for cell in titles[2:] if cell] == every and len(every) == n)
    rows = [line.split("\t") for line in lines[5:] if line.strip()]
    need_end(lines, rows)
    axes = cells_of(lines[4])
    need(len(axes) == 3 * n and all(re.fullmatch("[XYZxyz][0-9]*", cell) for cell in axes))
    mm = unit_mm(said.get("Units", ""))
    found = series(rows, labels, every, number(said.get("DataRate", "")), mm, True, True)
    return counted(found, len(rows), whole(said.get("NumFrames", str(len(rows)))))


def cells_of(line: str) -> list[str]:
    return [cell for cell in line.split("\t") if cell.strip()]


def counted(found: Values, rows: int, declared: int) -> Values:
    """Rows as many as declared, or those that are missing show as gaps."""
    need(declared in (rows, found["position_mm"].shape[2]))
    return found


def motive(raw: bytes, labels: Sequence[str]) -> Values:
    lines = lines_of(raw)
    first = [cell.strip() for cell in next(csv.reader([lines[0]]))]
    said = dict(zip(first[::2], first[1::2], strict=False))
    need(first[0] == "Format Version" and said.get("Length Units", "").strip())
    at = next((i for i, line in enumerate(lines) if line.lower().startswith("frame,")), 0)
    need(4 < at < 20 and not any(line.count('"') % 2 for line in lines[:at]))
    above = [line.split(",") for line in lines[1:at] if line.count(",") > 1]
    head = {cells[1]: cells for cells in above}
    need({"Type", "Name", ""} <= set(head) and len(head) == len(above))
    axes = lines[at].split(",")
    k = (len(axes) - 2) // 3
    need(axes[2:] == ["X", "Y", "Z"] * k)
    need([cell.lower() for cell in head["Type"][2:]] == ["marker"] * 3 * k)
    need(lines[at - 1].split(",")[2:] == ["Position"] * 3 * k)
    names = [cell.strip().strip('"') for cell in head["Name"][2:]]
    every = names[::3]
    need(names == [name for name in every for _ in range(3)] and len(every) == k)
    rows = [line.split(",") for line in lines[at + 1 :] if line.strip(", ")]
    need_end(lines, rows)
    rate = number(said.get("Export Frame Rate", ""))
    need(number(said.get("Capture Frame Rate", "")) > 0)
    found = series(rows, labels, every, rate, unit_mm(said["Length Units"]), True, True)
    need(max(len(rows), found["position_mm"].shape[2]) >= whole(said["Total Exported Frames"]))
    return found


def nexus(raw: bytes, labels: Sequence[str]) -> Values:
    lines = lines_of(raw)
    need(len(lines) > 6 and lines[0].strip() == "Trajectories")
    axes = [cell.strip() for cell in lines[3].split(",")]
    k = (len(axes) - 2) // 3
    need(axes == ["Frame", "Sub Frame", *["X", "Y", "Z"] * k])
    names = [cell.strip() for cell in lines[2].split(",")]
    every = names[2::3][:k]
    need([name for name in names if name] == every)
    units = {cell.strip().lower() for cell in lines[4].split(",")[2:]}
    need(len(units) == 1)
    end = next((i for i, line in enumerate(lines) if i > 4 and not line.strip(", ")), len(lines))
    rows = [line.split(",") for line in lines[5:end]]
    rows = [[row[0], *row[2:]] for row in rows]
    need_end(lines, rows)
    return series(rows, labels, every, number(lines[1]), unit_mm(units.pop()), True, False)


def qualisys(raw: bytes, labels: Sequence[str]) -> Values:
    said: dict[str, list[str]] = {}
    rows = []
    for line in lines_of(raw):
        cells = [cell.strip() for cell in line.split("\t")]
        if re.fullmatch("[A-Z][A-Z0-9_]{2,}", cells[0]) and not rows:
            need(cells[0] not in said or cells[0] == "EVENT")
            said[cells[0]] = cells[1:]
        elif any(cells):
            rows.append(cells)
    every = said.get("MARKER_NAMES", [])
    need(said.get("NO_OF_FRAMES") and every)
    need(
        said.get("NO_OF_MARKERS") == [str(len(every))]
        and said.get("DATA_INCLUDED", ["3D"]) == ["3D"]
    )
    rate = number(said.get("FREQUENCY", [""])[0])
    found = series(rows, labels, every, rate, 1.0, True, True, zero=True)
    return counted(found, len(rows), whole(said["NO_OF_FRAMES"][0]))


def poses(raw: bytes, labels: Sequence[str]) -> Values:
    lines = lines_of(raw)
    rate = re.search(r"Freq:\s*([0-9.]+)", lines[0])
    need(lines[0].startswith("#") and rate)
    rows = [re.split("[ \t]+", line.strip(" \t")) for line in lines[1:] if line.strip(" \t")]
    need(all(len(row) == 12 for row in rows))
    need(all(number(cell) is not None for row in rows for cell in row))
    own = [row[3::4] for row in rows]
    return series(own, labels, ["tracker"], number(rate[1]), 1000.0, False, False)  # type: ignore


def rec(raw: bytes, name: str) -> Values:
    """Start, length in ticks and diode of each pulse of an object, by time."""
    board, pulses = None, []
    for line in raw.split(b"\n")[:-1]:
        cells = line.rstrip(b"\r").split(b" ")
        if cells[1:3] == [name.encode(), b"CONFIG"] and board is None:
            try:
                board = json.loads(b" ".join(cells[3:]))["lighthouse_config"]
                need(board.keys() <= {"modelPoints", "channelMap"})
            except (ValueError, KeyError, TypeError, AttributeError):
                raise Unreadable from None
        is_pulse = len(cells) == 6 and cells[1:3] == [name.encode(), b"C"]
        whole_numbers = all(re.fullmatch(rb"[0-9]{1,10}", cell) for cell in cells[3:])
        if is_pulse and whole_numbers and re.fullmatch(rb"[0-9.]+", cells[0]):
            pulses.append([int(cell) for cell in cells[3:]])
    need(board and pulses and isinstance(board.get("channelMap"), list))
    found, time, before = [], 0, pulses[0][1]
    for channel, start, length in pulses:
        time += (start - before + 2**31) % 2**32 - 2**31
        before = start
        if channel in board["channelMap"] and length <= 400_000:
            found.append((time, length, board["channelMap"].index(channel)))
    need(found)
    found.sort(key=lambda one: one[0])
    table = np.array(found, float)
    table[:, 0] -= table[0, 0]
    return {"pulses": table, "board": np.array(board["modelPoints"], float)}


def dump(raw: bytes, n_diodes: int = 32) -> Values:
    """First sample, samples and diode of each whole pulse, by start."""
    need(len(raw) % 4 == 0 and raw)
    words = np.frombuffer(raw, "<u4")
    at = np.flatnonzero(words[1:] != words[:-1]) + 1
    found = []
    for bit in range(n_diodes):
        lit = (words >> bit & 1)[np.concatenate([[0], at])].astype(int)
        edges = np.flatnonzero(np.diff(lit))
        begins, ends = at[edges[lit[edges + 1] == 1]], at[edges[lit[edges + 1] == 0]]
        ends = ends[ends > begins[0]] if len(begins) else ends[:0]
        found += [(b, e - b, bit) for b, e in zip(begins, ends, strict=False)]
    found.sort(key=lambda one: (one[0], one[2]))
    return {"pulses": np.array(found, float), "words": len(words)}


def table_of(raw: bytes, columns: Sequence[str], exact: bool = True) -> list[dict[str, str]]:
    try:
        text = raw.decode("utf-8-sig")
        need(all(c in "\t\r\n" or category(c) not in ("Cc", "Zl", "Zp") for c in text))
        rows = [row for row in csv.reader(io.StringIO(text, newline=""), strict=True) if any(row)]
    except (csv.Error, UnicodeDecodeError):
        raise Unreadable from None
    need(rows)
    head = [cell.strip() for cell in rows[0]]
    need(head[: len(columns)] == list(columns) if exact else set(columns) <= set(head))
    need(all(len(row) == len(head) for row in rows))
    return [dict(zip(head, row, strict=True)) for row in rows[1:]]


def angles(raw: bytes) -> Values:
    columns = ("station", "axis", "cycle", "diode", "time_s", "angle_rad")
    roles = {"master": "0", "slave": "1"}
    rows = [
        [
            number(cell)
            for cell in (
                roles.get(row["station"].strip().lower(), row["station"]),
                *(row[c] for c in columns[1:]),
            )
        ]
        for row in table_of(raw, columns, exact=False)
    ]
    need(rows and np.isfinite(rows).all())
    rows.sort(key=lambda row: row[4])
    return {"hits": np.array(rows)}


def board(raw: bytes) -> Values:
    need(decoded(raw).splitlines()[0].strip())
    rows = table_of(raw, ("x_m", "y_m", "z_m"))
    return {"board": np.array([[number(row[c]) for c in ("x_m", "y_m", "z_m")] for row in rows])}


def sheet(raw: bytes) -> Values:
    """The cells of columns that hold text, row by row."""
    try:
        text = raw.rstrip(b"\x1a").decode("utf-8-sig")
    except UnicodeDecodeError:
        raise Unreadable from None
    need(not re.search(r'(^|\t) *"', QUOTED.sub(r"\1", text), re.M))
    text = QUOTED.sub(lambda cell: cell[1] + cell[2].replace('""', '"'), text)
    rows = [line for line in re.split(r"\r\n|\n|\r", text) if line.strip(" \t;,")]
    rows = [line for line in rows if not line.lstrip(' "').startswith("#")]
    need(rows and "\0" not in text)
    head, *cells = ([cell.strip() for cell in line.split("\t")] for line in rows)
    head = [cell.lower() for cell in head]
    while head and not head[-1]:
        head.pop()
    need(len(set(head)) == len(head))
    found = [dict(zip(head, [*row, *[""] * len(head)], strict=False)) for row in cells if any(row)]
    need(all(not any(row[len(head) :]) for row in cells))
    columns = ("recording", "path", "group", "unit", "comment", "camera_type")
    table = sorted([row.get(column, "") for column in columns] for row in found)
    return {"rows": table, "whole": found}


def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A mapping of JSON, each key of which stands once."""
    need(len(dict(pairs)) == len(pairs))
    return dict(pairs)


class Once(yaml.SafeLoader):
    """Whose mappings have each key once."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [key.value for key, _ in node.value]
        need(len(set(map(str, keys))) == len(keys))
        return super().construct_mapping(node, deep)


def yaml_of(raw: bytes) -> Any:
    """A document whose keys stand once, and a BOM first alone."""
    need(b"\xef\xbb\xbf" not in raw[3:])
    return yaml.load(raw.decode("utf-8-sig"), Once)


def configuration(raw: bytes) -> Values:
    """Leaves by dotted name; text that is a number is one."""
    try:
        found = yaml_of(raw)
    except (yaml.YAMLError, UnicodeDecodeError, ValueError, RecursionError):
        raise Unreadable from None
    need(isinstance(found, dict))
    leaves: dict[str, Any] = {}

    def collect(prefix: str, value: Any) -> None:
        if isinstance(value, dict):
            for key, inner in value.items():
                collect(f"{prefix}.{key}", inner)
        else:
            leaves[prefix] = leaf(value)

    collect("", found)
    return {"leaves": leaves}


def leaf(value: Any) -> Any:
    """A setting for comparison: however it is typed, `1e-3`, `0.001`, and `on` for true."""
    if isinstance(value, (list, tuple)):
        return [leaf(one) for one in value]
    text = str(value).strip()
    words = {"yes": "true", "on": "true", "no": "false", "off": "false", "null": "none", "": "none"}
    words |= {"true": "true", "false": "false", "none": "none", "nan": "nan", "-nan": "nan"}
    written = text in (text.lower(), text.upper(), text.capitalize())
    text = words.get(text.lower(), text) if written else text
    if "," in text:
        return [leaf(part) for part in text.split(",")]
    try:
        return float(text) if text != "nan" else text
    except ValueError:
        return text
