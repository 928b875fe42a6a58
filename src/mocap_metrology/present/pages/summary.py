"""The page that answers a user's first question: is it good, and if not, why."""

from __future__ import annotations

import base64
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from markupsafe import Markup

from mocap_metrology.lighthouse.published import QUANTITIES
from mocap_metrology.lighthouse.rotation import from_angles, log, mean, to_angles
from mocap_metrology.noise.assess.checks import COORDINATE
from mocap_metrology.present.calibration.calibration_table import calibration_rows
from mocap_metrology.present.pages import front, site
from mocap_metrology.present.pages.details import PaperTable
from mocap_metrology.present.pages.site import (
    EMPTY,
    Cell,
    Table,
    link,
    natural,
    table,
    typeset,
    word,
)
from mocap_metrology.present.plot.figure import VERDICT_WORDS
from mocap_metrology.present.tables import Record
from mocap_metrology.present.text.numbers import NINE_HOURS_S, duration_words, significant
from mocap_metrology.present.verdict.words import FRAME, MEANS, NEAR

MM = ("x_mm", "y_mm", "z_mm")
DEG = ("rx_deg", "ry_deg", "rz_deg")  # of a vector in master axes
MANY = 20  # calibrations of a group beyond which a row is a setup
POSE = ("x (mm)", "y (mm)", "z (mm)", "α (°)", "β (°)", "γ (°)")
HEAD = ("calibration", "verdict", *POSE, "σ (mm)", "σ (°)", "why")
SETUP_HEAD = (
    *("setup", "calibrations", "verdicts", *POSE, "scatter (mm)", "scatter (°)"),
    "not right (in so many)",
)
NOTE = (
    "x, y, z and α, β, γ: translation and rotation of the slave in the master's frame. σ: one "
    "standard deviation as the estimator states it, largest of three axes."
)
SETUP_NOTE = (
    "A row is a setup, of which every calibration repeats the same poses of the stations. x, y, "
    "z and α, β, γ: mean translation and rotation of the slave in the master's frame; scatter: "
    "standard deviation (n - 1) among the calibrations, largest of three axes."
)


def calibrations(rows: Sequence[Record], address: Callable[[str], str]) -> tuple[Table, list[str]]:
    """Table of the calibrations of a group, and its notes.

    rows: `calibration`, `setup`, `source`, `pose` (contents of pose.json); address: of a name.
    """
    if len(rows) > MANY:
        setups = dict.fromkeys(row["setup"] for row in rows)
        cells = [setup_row(name, [r for r in rows if r["setup"] == name]) for name in setups]
        return table(SETUP_HEAD, cells), [SETUP_NOTE]
    cells = [_row(row, flat, address) for row, flat in _flat(rows)]
    return table(HEAD, cells), [NOTE]


def _flat(rows: Sequence[Record]) -> list[tuple[Record, Record]]:
    return list(zip(rows, calibration_rows(rows), strict=True))


def _row(row: Record, flat: Record, address: Callable[[str], str]) -> list[object]:
    name = row["calibration"]
    sigma = [max(flat[f"sigma_{axis}"] for axis in axes) for axes in (MM, DEG)]
    return [
        link(address(name), name),
        word(flat["verdict"]),
        *_pose([flat[quantity] for quantity in QUANTITIES]),
        *(significant(value) or EMPTY for value in sigma),
        flat["reason"],
    ]


def _pose(values: Sequence[float] | np.ndarray) -> list[str]:
    if np.isnan(values).any():
        return [EMPTY] * 6
    return [f"{v:.{digits}f}" for v, digits in zip(values, (1, 1, 1, 3, 3, 3), strict=True)]


def setup_row(name: str, rows: Sequence[Record]) -> list[object]:
    """Cells of a setup: how many of each verdict, mean pose, scatter, and what was not right."""
    flat = calibration_rows(rows)
    words = Counter(row["verdict"] for row in flat)
    shown = [word(w, words[w]) for w in dict.fromkeys((*VERDICT_WORDS, *words)) if words[w]]
    wrong = Counter(
        check["name"] for row in rows for check in row["pose"]["checks"] if check["ok"] is False
    )
    values = np.array([[row[quantity] for quantity in QUANTITIES] for row in flat])
    values = values[~np.isnan(values).any(axis=1)]
    centre, mm, deg = spread(values)
    return [
        name,
        len(rows),
        Markup(" ").join(shown),
        *_pose(centre),
        *(significant(value) or EMPTY for value in (mm, deg)),
        ", ".join(f"{what} ({count})" for what, count in wrong.most_common()) or EMPTY,
    ]


def spread(values: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Mean pose of rows x, y, z in mm and alpha, beta, gamma in deg, and the largest standard
    deviations (n - 1) of a translation's component and of a rotation vector's, NaN for one row."""
    if not len(values):
        return np.full(6, np.nan), np.nan, np.nan
    turns = np.array([from_angles(*np.radians(row[3:])) for row in values])
    centre = mean(turns)
    pose = np.concatenate([values[:, :3].mean(axis=0), np.degrees(to_angles(centre))])
    if len(values) < 2:
        return pose, np.nan, np.nan
    vectors = np.degrees([log(turn @ centre.T) for turn in turns])
    mm, deg = (float(v.std(axis=0, ddof=1).max()) for v in (values[:, :3], vectors))
    return pose, mm, deg


Address = Callable[[str, str], str]  # kind (recording, group, ...), name -> address or nothing

DURATIONS_S = (1, 10, 60)
MOST = 3  # warnings shown for a recording
MOST_MEMBERS = 12  # of a group on the front of the report
RECORDING_HEAD = (
    *("recording", "verdict", f"{NEAR} (mm)", f"{FRAME} (mm)"),
    *(f"{mean} (mm)" for mean in MEANS),
    *("mostly", "why"),
)
RECORDINGS_NOTE = (
    "All numbers are for the worst coordinate. One frame within 1 s: scatter of single frames. One "
    "frame, mean of 1, 10, 60 s: standard uncertainty of a frame and of such a mean, relative to "
    "the mean of an hour or of a shorter recording. The verdict compares that of a frame with its "
    "limits. Mostly: the kind of noise with the largest share. Why: the quantity that decides the "
    "verdict, and warnings, shortened."
)
TABLES_NOTE = "Every table of these results, on a page and as CSV."
INSIDE = (  # where names are no links
    "In the menu of this report, figures are in the categories “5 Recordings”, “6 Calibrations” "
    "and “4 Groups”; tables and figures of the papers in “2 Skurowski & Pawlyta 2019” and “3 "
    "Jansen et al. 2019”. The first page of the report is this page with links to the files beside "
    "it."
)
PUBLISHED = "skurowski2019"  # group whose twins are made from the coefficients of a paper
APART = "These subsets of cameras do not share their frames: "


@dataclass(frozen=True)
class Found:
    """What the page is made of. Every list may be empty.

    recordings: contents of verdict.json; calibrations: rows `calibration`, `group`, `setup`,
    `source`, `pose` (contents of pose.json); refused: `kind`, `name`, `group`, `why`; cameras:
    by group, what <group>_cameras.json holds: `short`, a line a camera type, and `apart`; changes:
    by group, sentences on comparisons with earlier recordings; picture, caption: of
    the recordings, as PNG.
    """

    recordings: Sequence[Record] = ()
    calibrations: Sequence[Record] = ()
    refused: Sequence[Record] = ()
    cameras: Mapping[str, Record] = field(default_factory=dict)
    changes: Mapping[str, Sequence[str]] = field(default_factory=dict)
    picture: bytes = b""
    caption: str = ""


@dataclass(frozen=True)
class Section:
    """A group of recordings or of calibrations: a sentence, changes, a table, notes below it, and
    links to its members."""

    title: str
    address: str
    sentence: str
    table: Table
    notes: Sequence[str]
    members: Sequence[Cell] = ()
    changes: Sequence[str] = ()


@dataclass(frozen=True)
class Paper:
    """A paper: its page, how many of its claims hold or do not, and how its tables compare."""

    title: str
    address: str
    claims: str = ""
    tables: Sequence[PaperTable] = ()


def page(
    found: Found,
    address: Address = lambda kind, name: "",
    papers: Sequence[Paper] = (),
    tables: Sequence[str] = (),
    part: bool = False,
) -> str:
    """The page: an answer and a picture, what was refused, one's own groups, the papers, the other
    groups, all tables.

    tables: names; part: to be included in another page, as a front that fits a screen: links to
    the recordings of a group instead of its table.
    """
    groups = [*_recordings(found, address), *_calibrations(found, address)]
    own = front.own({"recording": found.recordings, "calibration": found.calibrations})
    mine = [row for rows in own.values() for row in rows]
    return site.render(
        "summary.html",
        front.title(mine),
        part=part,
        answers=[
            front.answer(kind, rows, sum(one["kind"] == kind for one in found.refused))
            for kind, rows in own.items()
            if rows
        ],
        changes=front.changes(found.changes, front.groups(mine)),
        picture=base64.b64encode(found.picture).decode() if found.picture else "",
        picture_says=found.caption,
        inside=INSIDE,
        quick=_quick(found.recordings),
        refused=_refused(found.refused),
        own=[section for group, section in groups if not front.of_paper(group)],
        others=[section for group, section in groups if front.of_paper(group)],
        papers=papers,
        note=RECORDINGS_NOTE if found.recordings else "",
        empty=not (found.recordings or found.calibrations or found.refused),
        tables=_tables(tables) if tables else None,
        tables_note=TABLES_NOTE,
    )


def _recordings(found: Found, address: Address) -> Iterator[tuple[str, Section]]:
    for group, rows in _groups(found.recordings, "recording"):
        cells = [recording_row(row, address) for row in rows]
        yield (
            group,
            Section(
                f"{group}: recordings",
                address("group", group),
                sentence("recording", rows),
                table(RECORDING_HEAD, cells, words=(7,)),
                _cameras(group, rows, found.cameras.get(group, {})),
                _members("recording", rows, address),
                found.changes.get(group, ()),
            ),
        )


def _calibrations(found: Found, address: Address) -> Iterator[tuple[str, Section]]:
    for group, rows in _groups(found.calibrations, "calibration"):
        shown, notes = calibrations(rows, lambda name: address("calibration", name))
        title = f"{group}: calibrations"
        where = address("group", group)
        members = _members("calibration", rows, address)
        yield group, Section(title, where, sentence("calibration", rows), shown, notes, members)


def _members(kind: str, rows: Sequence[Record], address: Address) -> list[Cell]:
    """Links to some recordings or calibrations of a group, each with its word."""
    shown = [
        link(address(kind, row[kind]), row[kind]) + Markup(" ") + word(_word(row))
        for row in sorted(rows, key=front.badness, reverse=True)
    ]
    more = len(shown) - MOST_MEMBERS
    return [*shown[:MOST_MEMBERS], *([f"and {more} more"] if more > 0 else [])]


def _groups(rows: Sequence[Record], kind: str) -> Iterator[tuple[str, list[Record]]]:
    """Groups with their rows in natural order, those that were measured before twins."""
    of: dict[str, list[Record]] = {}
    for row in sorted(rows, key=lambda row: (row["source"] == "twin", natural(row[kind]))):
        of.setdefault(row["group"], []).append(row)
    yield from of.items()


def _tables(names: Sequence[str]) -> Table:
    pages = [link(f"pages/{name}.html", name) for name in sorted(names, key=natural)]
    files = [link(f"tables/{name}.csv", f"{name}.csv") for name in sorted(names, key=natural)]
    return table(("table to read", "all columns, all digits"), zip(pages, files, strict=True))


def _quick(rows: Sequence[Record]) -> tuple[str, str] | None:
    """A note that twins of recordings of nine hours are shorter, where they are."""
    lengths = _lengths(rows)
    if not lengths or round(max(lengths)) >= NINE_HOURS_S:
        return None
    return (
        f"A quick look: the simulated stand-ins (twins) are {_texts(lengths)} long.",
        f" The recordings of Skurowski & Pawlyta last {duration_words(NINE_HOURS_S)}. Slow noise "
        "hardly shows in so short a time: whole-length verdicts and coefficients can differ.",
    )


def _lengths(rows: Sequence[Record]) -> list[float]:
    """Durations of the twins among recordings, in s, each once and rising."""
    known = (row.get("duration_s") for row in rows if row["source"] == "twin" and "pose" not in row)
    return sorted({float(seconds) for seconds in known if seconds is not None})


def _texts(lengths: Sequence[float]) -> str:
    """`10 min`, or `20 s to 10 min`."""
    return " to ".join(dict.fromkeys(duration_words(k) for k in (lengths[0], lengths[-1])))


def _cameras(group: str, rows: Sequence[Record], told: Record) -> list[str]:
    """A line for each camera type, and once the limits of subsets that share no frames."""
    lines = [*told.get("short", ())]
    if told.get("apart") and all(row["source"] == "twin" for row in rows):
        numbers = "the published numbers" if group == PUBLISHED else "numbers of its own"
        table_of = "of the published table" if group == PUBLISHED else "of those numbers"
        lines.append(
            f"{APART}each is a simulation of its own, made from {numbers}, so that a rise is one "
            f"{table_of}."
        )
    elif told.get("apart"):
        lines.append(f"{APART}only a rise is evidence on a camera, not the noise it adds.")
    return lines


def _refused(rows: Sequence[Record]) -> Table | None:
    if not rows:
        return None
    cells = [(row["name"], row["kind"], word("refused"), row["why"]) for row in rows]
    return table(("name", "kind", "verdict", "why"), cells)


def sentence(kind: str, rows: Sequence[Record]) -> str:
    """`23 recordings, all simulated (twins of 10 min): 20 good, 3 usable.`"""
    words = Counter(_word(row) for row in rows)
    order = [w for w in (*VERDICT_WORDS, *words) if w in words]
    counts = ", ".join(f"{words[w]} {w}" for w in dict.fromkeys(order))
    twins = sum(row["source"] == "twin" for row in rows)
    lengths = _lengths(rows)
    of = f" of {_texts(lengths)}" if lengths else ""
    if twins == len(rows):
        source = f"simulated (a twin{of})" if twins == 1 else f"all simulated (twins{of})"
    else:
        measured = f"{len(rows) - twins} measured"
        source = f"{twins} simulated (twins{of}), {measured}" if twins else "measured"
    plural = "" if len(rows) == 1 else "s"
    return f"{len(rows)} {kind}{plural}, {source}: {counts}."


def _word(row: Record) -> str:
    return str(front.verdict_of(row)["word"])


def recording_row(row: Record, address: Address) -> list[object]:
    """Cells of a recording: in every column of numbers the worst of its coordinates."""
    series = {k: v for k, v in row["series"].items() if COORDINATE.fullmatch(k)}
    numbers = [[one.get(key) for one in series.values()] for key in ("sigma_frame_mm", "frame_mm")]
    numbers += [[_mean(one, t) for one in series.values()] for t in DURATIONS_S]
    return [
        link(address("recording", row["recording"]), row["recording"]),
        word(row["word"]),
        *(significant(_greatest(values)) or EMPTY for values in numbers),
        _mostly(series.values()),
        Markup("<br>").join(map(typeset, why(row))),
    ]


def why(row: Record) -> list[str]:
    """What the word of a recording rests on, what else allows no better one, and warnings."""
    checks = [row["reason"], *(cap["reason"] for cap in row.get("caps", ()))]
    found = row.get("sentences", ())
    if any(re.search(r"\bmoves?: ", check) for check in checks):  # stated already
        found = [one for one in found if "seems to move" not in one["words"]]
    return [*map(front.shorter, checks), *_told(found)]


def _greatest(values: Iterable[float | None]) -> float | None:
    return max((value for value in values if value is not None), default=None)


def _mean(series: Record, duration_s: float) -> float | None:
    """Uncertainty of a mean over this time, if requested."""
    found = (m for m in series.get("means", ()) if m["duration_s"] == duration_s)
    mean: Record = next(found, {})
    return mean.get("uncertainty_mm")


def _mostly(series: Iterable[Record]) -> str:
    """`random walk 70 %` of the coordinate whose frames are worst."""
    known = [one for one in series if one.get("frame_mm") is not None and one.get("shares")]
    if not known:
        return EMPTY
    shares = max(known, key=lambda one: one["frame_mm"])["shares"]
    name = max(shares, key=lambda kind: shares[kind])
    return f"{name.partition(' (')[0]} {100 * shares[name]:.0f} %"


def _told(sentences: Sequence[Record]) -> list[str]:
    """What was found that is worth a warning, up to its first semicolon; the rest is in the
    figures."""
    found = [one["words"] for one in sentences if one["severity"] == "warning"]
    warnings = [f"{words.partition('; ')[0].rstrip('.')}." for words in found]
    more, words = len(warnings) - MOST, warnings[:MOST]
    return [*words, f"And {more} more, see its figures."] if more > 0 else words
