"""The page that answers a user's first question: is it good, and if not, why."""

from __future__ import annotations

import base64
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup

from mocap_metrology.common.types import Record
from mocap_metrology.lighthouse.assess.rows import calibration_rows, spread
from mocap_metrology.lighthouse.published import QUANTITIES
from mocap_metrology.noise.assess.checks import COORDINATE
from mocap_metrology.present.changes import OUTCOMES
from mocap_metrology.present.pages import site
from mocap_metrology.present.pages.details import PaperTable
from mocap_metrology.present.pages.site import EMPTY, link, word
from mocap_metrology.present.plot.figure import VERDICT_WORDS
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import NINE_HOURS_S, duration_words, significant
from mocap_metrology.present.verdict.figure import worst_frame
from mocap_metrology.present.verdict.words import FRAME, MEANS, NEAR, is_stated

OF_PAPERS = ("skurowski2019", "jansen2019")  # how groups of the papers' own begin
PUBLISHED = "skurowski2019"  # group whose twins are made from the coefficients of a paper
ORDER = list(VERDICT_WORDS)
SHORTER = (  # what a sentence loses in the table
    r" \([^()]*…[^()]*\)",
    r" about the mean of [^;]*",
    r", more than clean [^;]*",
    r"( \([^()]*\))?: its numbers .*(?=\.$)",
    r"; (the distance \S+ is still|still) valid.*(?=\.$)",
    r": (without a distance|nothing is measured there),.*(?=\.$)",
)
DURATIONS_S = (1, 10, 60)
CHANGED, MOST_CHANGED = OUTCOMES[:3], 3  # those whose recordings are named, and how many
MOST_WARNINGS = 3  # shown for a recording
MOST_MEMBERS = 12  # of a group on the front of the report
MOST_ROWS = 20  # calibrations of a group beyond which a row is a setup
UNCERTAINTIES = tuple(f"{of} (mm)" for of in (NEAR, FRAME, *MEANS))
RECORDING_HEAD = ("recording", "verdict", *UNCERTAINTIES, "mostly", "why")
POSE = ("x (mm)", "y (mm)", "z (mm)", "α (°)", "β (°)", "γ (°)")
CALIBRATION_HEAD = ("calibration", "verdict", *POSE, "σ (mm)", "σ (°)", "why")
SCATTER = ("scatter (mm)", "scatter (°)")
SETUP_HEAD = ("setup", "calibrations", "verdicts", *POSE, *SCATTER, "not right (in so many)")
AXES = ("x_mm", "y_mm", "z_mm"), ("rx_deg", "ry_deg", "rz_deg")  # of a vector in master axes

Address = Callable[[str, str], str]  # kind (recording, group, ...), name -> address or nothing


@dataclass(frozen=True)
class Verdicts:
    """What the page is made of. Every list may be empty.

    recordings: contents of verdict.json; calibrations: rows `calibration`, `group`, `setup`,
    `source`, `pose` (contents of pose.json); refused: `kind`, `name`, `group`, `why`; cameras:
    by group, what <group>_cameras.json holds: `short`, a line a camera type, and `apart`; changes:
    by group, what <group>_compare.json holds: `words`, sentences on comparisons with earlier
    recordings, and `outcomes`, a word for each recording; picture, caption: of
    the recordings, as PNG; monitors: by name, a line on each facility that is watched.
    """

    recordings: Sequence[Record] = ()
    calibrations: Sequence[Record] = ()
    refused: Sequence[Record] = ()
    cameras: Mapping[str, Record] = field(default_factory=dict)
    changes: Mapping[str, Record] = field(default_factory=dict)
    picture: bytes = b""
    caption: str = ""
    monitors: Mapping[str, str] = field(default_factory=dict)

    def rows(self) -> list[Record]:
        """Recordings and calibrations, each with its `kind`, `name`, `word` and `reason`, those
        that were measured before twins and in natural order."""
        rows = [{**r, "kind": "recording", "name": r["recording"]} for r in self.recordings]
        for r in self.calibrations:
            named = {"kind": "calibration", "name": r["calibration"]}
            rows.append({**r, **r["pose"]["verdict"], **named})
        rows.sort(key=lambda r: (r["source"] == "twin", site.natural(r["name"])))
        return sorted(rows, key=lambda r: r["kind"], reverse=True)


class Paper(NamedTuple):
    """A paper: its page, how many of its claims hold or do not, and how its tables compare."""

    title: str
    address: str
    claims: str = ""
    tables: Sequence[PaperTable] = ()


def page(
    verdicts: Verdicts,
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
    rows, refused = verdicts.rows(), verdicts.refused
    mine = own_rows(rows)
    groups = sorted({row["group"] for row in mine})
    changed = [verdicts.changes[group] for group in groups if group in verdicts.changes]
    sections = [*_sections(verdicts, rows, address)]
    names = sorted(tables, key=site.natural)
    shown = [(link(f"pages/{n}.html", n), link(f"tables/{n}.csv", f"{n}.csv")) for n in names]
    wrong = [(one["name"], one["kind"], word("refused"), one["why"]) for one in refused]
    return site.render(
        "summary.html",
        f"Verdict on {', '.join(groups)}" if 0 < len(groups) <= 3 else "Verdicts",
        part=part,
        answers=[
            answer(kind, of_kind, sum(one["kind"] == kind for one in refused))
            for kind in ("recording", "calibration")
            if (of_kind := [row for row in mine if row["kind"] == kind])
        ],
        changes=[
            *(line for group in groups for line in blamed(verdicts.cameras.get(group, {}))),
            *(_watched(address("monitor", name), line) for name, line in verdicts.monitors.items()),
            *changes(changed),
        ],
        picture=base64.b64encode(verdicts.picture).decode(),
        picture_says=verdicts.caption,
        notes=captions,
        quick=_shortened_twins(rows),
        refused=site.table(("name", "kind", "verdict", "why"), wrong) if wrong else None,
        own=[section for section in sections if not section["group"].startswith(OF_PAPERS)],
        others=[section for section in sections if section["group"].startswith(OF_PAPERS)],
        papers=papers,
        recordings=bool(verdicts.recordings),
        empty=not (rows or refused),
        tables=site.table(("table to read", "all columns, all digits"), shown) if shown else None,
    )


def own_rows(rows: Sequence[Record]) -> list[Record]:
    """Rows of groups that are not a paper's, or all where there are no others; the worst first."""
    mine = [row for row in rows if not row["group"].startswith(OF_PAPERS)]
    return sorted(mine or rows, key=badness, reverse=True)


def badness(row: Record) -> tuple[int, float]:
    """Key of an order in which the worst is last."""
    point = worst_frame(row) if "series" in row else None
    known = row["word"] in ORDER
    return ORDER.index(row["word"]) if known else len(ORDER), point[0] if point else 0.0


def _counted(rows: Sequence[Record]) -> dict[str, int]:
    """How many have each word, in order."""
    counts = Counter(str(row["word"]) for row in rows)
    return {word: counts[word] for word in dict.fromkeys((*ORDER, *counts)) if counts[word]}


def answer(kind: str, rows: Sequence[Record], refused: int = 0) -> str:
    """How many of some recordings or calibrations (worst first) are good, how many others were
    refused, which is worst, and why: `5 of 7 recordings are good, 2 usable. The worst is hall-7
    (usable): ...`."""
    worst, total = rows[0], len(rows) + refused
    why = shorter(worst["reason"]).rstrip(".")
    if total == 1:
        return f"{worst['name']} is {worst['word']}: {why}."
    counts = _counted(rows) | ({"refused": refused} if refused else {})
    good = counts.pop("good", 0)
    parts = [f"{good} of {total} {kind}s are good", *(f"{n} {w}" for w, n in counts.items())]
    first = f"{', '.join(parts)}."
    if worst["word"] != "good":
        return f"{first} The worst is {worst['name']} ({worst['word']}): {why}."
    least = f" The least precise is {worst['name']}: {why}."
    return first + (least if kind == "recording" else "")


def _lengths(rows: Sequence[Record]) -> list[float]:
    """Shortest and longest duration of the twins among recordings, in s."""
    twins = [row["duration_s"] for row in rows if row["source"] == "twin" and row.get("duration_s")]
    return [min(twins), max(twins)] if twins else []


def origin(rows: Sequence[Record]) -> str:
    """`measured`, `all simulated (twins of 10 min)`, `5 simulated (twins), 2 measured`."""
    twins = sum(row["source"] == "twin" for row in rows)
    if not twins:
        return "measured"
    lengths = " to ".join(dict.fromkeys(map(duration_words, _lengths(rows))))
    simulated = f"simulated ({'a twin' if len(rows) == 1 else 'twins'}"
    simulated += f" of {lengths})" if lengths else ")"
    if twins < len(rows):
        return f"{twins} {simulated}, {len(rows) - twins} measured"
    return simulated if twins == 1 else f"all {simulated}"


def _shortened_twins(rows: Sequence[Record]) -> str:
    """Words on twins of a paper's recordings of nine hours that are shorter."""
    lengths = _lengths([row for row in rows if row["group"].startswith(OF_PAPERS)])
    if not lengths or round(lengths[-1]) >= NINE_HOURS_S:
        return ""
    shown = " to ".join(dict.fromkeys(map(duration_words, lengths)))
    return f"A quick look: the simulated stand-ins (twins) are {shown} long."


def _watched(address: str, line: str) -> Markup:
    """The line on a facility, whose first words, its name, lead to its page."""
    name, _, words = line.partition(": ")
    return link(address, name) + Markup(": ") + site.typeset(words)


def changes(compared: Sequence[Record]) -> list[str]:
    """What changed since the recordings that others are compared with: the sentence of one, of
    several how many have each outcome, with the names of those that changed. compared: contents of
    <group>_compare.json."""
    sentences = [words for of in compared for words in of["words"]]
    if len(sentences) < 2:
        return sentences
    named: dict[str, list[str]] = {outcome: [] for outcome in OUTCOMES}
    for name, outcome in (pair for of in compared for pair in of["outcomes"].items()):
        named[outcome].append(name)
    shown = [
        f"{len(names)} {outcome}{_names(names) if outcome in CHANGED else ''}"
        for outcome, names in named.items()
        if names
    ]
    return [f"Of {len(sentences)} recordings compared with another: {', '.join(shown)}."]


def _names(names: Sequence[str]) -> str:
    more = [f"{len(names) - MOST_CHANGED} more"] if len(names) > MOST_CHANGED else []
    return f" ({', '.join([*names[:MOST_CHANGED], *more])})"


def shorter(sentence: str) -> str:
    """A reason without its interval and its explanation."""
    for pattern in SHORTER:
        sentence = re.sub(pattern, "", sentence, count=1)
    return re.sub(r"^(One frame of \S+) is uncertain by", r"\1:", sentence)


def _sections(
    verdicts: Verdicts, rows: Sequence[Record], address: Address
) -> Iterator[dict[str, Any]]:
    """A group of recordings or of calibrations: a sentence, changes, a table, notes below it, and
    links to its members."""
    for kind, group in dict.fromkeys((row["kind"], row["group"]) for row in rows):
        of = [row for row in rows if (row["kind"], row["group"]) == (kind, group)]
        if kind == "recording":
            table = site.table(RECORDING_HEAD, [recording_row(r, address) for r in of], words=(7,))
            notes = _cameras(group, of, verdicts.cameras.get(group, {}))
        else:
            table, note = calibrations(of, address)
            notes = [note]
        shown = [
            link(address(kind, row["name"]), row["name"]) + Markup(" ") + word(row["word"])
            for row in sorted(of, key=badness, reverse=True)
        ]
        more = len(shown) - MOST_MEMBERS
        counts = ", ".join(f"{count} {name}" for name, count in _counted(of).items())
        yield {
            "group": group,
            "title": f"{group}: {kind}s",
            "address": address("group", group),
            "sentence": f"{len(of)} {kind}{'s'[len(of) == 1 :]}, {origin(of)}: {counts}.",
            "table": table,
            "notes": notes,
            "members": [*shown[:MOST_MEMBERS], *([f"and {more} more"] if more > 0 else [])],
            "changes": verdicts.changes.get(group, {}).get("words", ())
            if kind == "recording"
            else (),
        }


def _cameras(group: str, rows: Sequence[Record], cameras: Record) -> list[str]:
    """A line for each camera type, and once the limits of subsets that share no frames."""
    lines = [*cameras.get("short", ())]
    if not cameras.get("apart"):
        return lines
    if not all(row["source"] == "twin" for row in rows):
        return [*lines, captions.APART_MEASURED]
    return [*lines, captions.APART_PUBLISHED if group == PUBLISHED else captions.APART_SIMULATED]


def blamed(cameras: Record) -> list[str]:
    """Lines on the camera types of which a camera is noisy or raises the noise."""
    types = {row["camera_type"] for key in ("noisy", "raised") for row in cameras.get(key, ())}
    return [line for line in cameras.get("short", ()) if line.partition(": ")[0] in types]


def recording_row(row: Record, address: Address) -> list[object]:
    """Cells of a recording: in every column of numbers the worst of its coordinates."""
    series = [one for name, one in row["series"].items() if COORDINATE.fullmatch(name)]
    numbers = [[one.get(key) for one in series] for key in ("sigma_frame_mm", "frame_mm")]
    means = [{m["duration_s"]: m["uncertainty_mm"] for m in one.get("means", ())} for one in series]
    numbers += [[of.get(t) for of in means] for t in DURATIONS_S]
    known = [one for one in series if one.get("frame_mm") is not None and one.get("shares")]
    shares = max(known, key=lambda one: one["frame_mm"])["shares"] if known else {"": 0}
    name = max(shares, key=lambda kind: shares[kind])
    return [
        link(address("recording", row["recording"]), row["recording"]),
        word(row["word"]),
        *(significant(_greatest(values)) or EMPTY for values in numbers),
        f"{name.partition(' (')[0]} {100 * shares[name]:.0f} %" if known else EMPTY,
        Markup("<br>").join(map(site.typeset, why(row))),
    ]


def _greatest(values: Iterable[float | None]) -> float | None:
    return max((value for value in values if value is not None), default=None)


def why(row: Record) -> list[str]:
    """What the word of a recording rests on, what else allows no better one, and warnings up to
    their first semicolon; the rest is in the figures."""
    checks = [row["reason"], *(cap["reason"] for cap in row.get("caps", ()))]
    every = [one for one in row.get("sentences", ()) if one["severity"] == "warning"]
    warned = [one["words"] for one in every if not is_stated(one, row)]
    warnings = [f"{words.partition('; ')[0].rstrip('.')}." for words in warned]
    more = len(warnings) - MOST_WARNINGS
    rest = [f"And {more} more, see its figures."] if more > 0 else []
    return [*map(shorter, checks), *warnings[:MOST_WARNINGS], *rest]


def calibrations(rows: Sequence[Record], address: Address) -> tuple[site.Table, str]:
    """Table of the calibrations of a group, of many a row a setup, and its note."""
    if len(rows) > MOST_ROWS:
        setups = dict.fromkeys(row["setup"] for row in rows)
        cells = [_setup(name, [row for row in rows if row["setup"] == name]) for name in setups]
        return site.table(SETUP_HEAD, cells), captions.SETUPS_NOTE
    cells = [
        [
            link(address("calibration", row["calibration"]), row["calibration"]),
            word(row["verdict"]),
            *_pose([row[quantity] for quantity in QUANTITIES]),
            *(significant(max(row[f"sigma_{a}"] for a in axes)) or EMPTY for axes in AXES),
            row["reason"],
        ]
        for row in calibration_rows(rows)
    ]
    return site.table(CALIBRATION_HEAD, cells), captions.CALIBRATIONS_NOTE


def _pose(values: Sequence[float] | np.ndarray) -> list[str]:
    if np.isnan(values).any():
        return [EMPTY] * 6
    return [f"{v:.{1 if k < 3 else 3}f}" for k, v in enumerate(values)]


def _setup(name: str, rows: Sequence[Record]) -> list[object]:
    """Cells of a setup: how many of each verdict, mean pose, scatter, and what was not right."""
    checks = (check for row in rows for check in row["pose"]["checks"])
    wrong = Counter(check["name"] for check in checks if check["ok"] is False)
    values = np.array([[row[name] for name in QUANTITIES] for row in calibration_rows(rows)])
    centre, mm, deg = spread(values[~np.isnan(values).any(axis=1)])
    return [
        name,
        len(rows),
        Markup(" ").join(word(text, count) for text, count in _counted(rows).items()),
        *_pose(centre),
        *(significant(value) or EMPTY for value in (mm, deg)),
        ", ".join(f"{what} ({count})" for what, count in wrong.most_common()) or EMPTY,
    ]
