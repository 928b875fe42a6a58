"""Values of a row for rules, and selections of rows of accepted recordings and calibrations."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, groupby, pairwise
from operator import attrgetter
from typing import Any, Generic, TypeVar

import pandas as pd

from mocap_metrology.lighthouse.simulate.network_twin import NetworkTwin
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin
from mocap_metrology.noise.twins.twin import Twin
from mocap_workflow.calibration_twins import CalibrationTwin
from mocap_workflow.calibrations import CalibrationRow
from mocap_workflow.recording_twins import AnyTwin
from mocap_workflow.recordings import RecordingRow
from mocap_workflow.rows import SheetRow

OfSheet = TypeVar("OfSheet", RecordingRow, CalibrationRow)
Twins = Mapping[str, AnyTwin]


@dataclass(frozen=True)
class Sheet(Generic[OfSheet]):
    """Checked rows of one kind, by name."""

    kind: type[OfSheet]
    rows: Mapping[str, OfSheet]

    @cached_property
    def table(self) -> pd.DataFrame:
        """What rules select by, for `lookup`: name, `group`, `source`, `setup` of a calibration,
        what a recording is `about`, of each row."""
        shown = ("group", "source", "setup" if "setup" in self.kind.columns() else "about")
        table = {name: [getattr(row, name) for row in self.rows.values()] for name in shown}
        return pd.DataFrame({self.kind.KIND: list(self.rows), **table}, dtype=str)

    def pattern(self, **values: str) -> str:
        """Regular expression of the names of rows that have these values in `table`."""
        return any_of(
            name
            for name, row in self.rows.items()
            if all(getattr(row, key) == value for key, value in values.items())
        )

    @property
    def groups(self) -> list[str]:
        """Groups in the order of their first rows."""
        return list(dict.fromkeys(row.group for row in self.rows.values()))


def any_of(names: Iterable[str]) -> str:
    """Regular expression of exactly these names; of nothing when there is none."""
    return "|".join(re.escape(name) for name in dict.fromkeys(names)) or "(?!)"


paths = attrgetter("paths")


def cells(*columns: str) -> Callable[[SheetRow], list[str]]:
    """Function of a row: what it has in these columns, without what is empty."""
    return lambda row: [value for name in columns if (value := getattr(row, name))]


covariates, references_of, seen_by = cells("covariate"), cells("reference"), cells("receiver")


def names(rows: Iterable[OfSheet]) -> list[str]:
    return [row.name for row in rows]


def named(rows: Iterable[OfSheet], names: Iterable[str]) -> list[OfSheet]:
    """Those of the rows that have these names, in the order of the names."""
    by_name = {row.name: row for row in rows}
    return [by_name[name] for name in dict.fromkeys(names) if name in by_name]


# Recordings.

subset = attrgetter("camera_type", "n_cameras")  # by it the first paper names its recordings


def having(column: str) -> Callable[[Iterable[OfSheet]], list[OfSheet]]:
    """Recordings or calibrations with something in this column."""
    return lambda rows: [row for row in rows if getattr(row, column)]


def with_place(rows: Sequence[RecordingRow]) -> list[RecordingRow]:
    """Recordings whose place in the volume has a name; none if it is the same for all."""
    placed = [row for row in rows if row.place]
    return placed if len({row.place for row in placed}) > 1 else []


def with_points(rows: Sequence[RecordingRow]) -> list[RecordingRow]:
    """Recordings at reference points, in the order of their dates, then of their names."""
    return sorted((row for row in rows if row.point), key=_date)


def over_dates(rows: Sequence[RecordingRow]) -> list[RecordingRow]:
    """Recordings of the same cameras on three days or more."""
    return named(rows, chain(*series_over_dates(rows)))


def subsets(rows: Sequence[RecordingRow]) -> list[RecordingRow]:
    """Recordings of subsets of the same cameras, take by take."""
    return named(rows, chain(*takes(rows)))


def scaled(rows: Sequence[RecordingRow]) -> Sequence[RecordingRow]:
    """All of them, if two are of one camera type and different numbers of cameras."""
    kinds = {(row.camera_type, row.n_cameras) for row in rows if row.n_cameras}
    return rows if len(kinds) > len({kind for kind, _ in kinds}) else []


def references(rows: Iterable[RecordingRow], others: Sequence[RecordingRow]) -> list[RecordingRow]:
    """Those of the others that these are compared with."""
    return named(others, (row.compare_with for row in rows if row.compare_with))


def with_and_without_failing(rows: Sequence[RecordingRow]) -> list[RecordingRow]:
    """The first paper's ten Vantage cameras, of which one failed, and the others without it."""
    first_of = {subset(row): row for row in reversed(rows)}
    pair = [first_of.get(("Vantage", count)) for count in (10, 9)]
    both = [row for row in pair if row]
    return both if len(both) == len(pair) else []


def full_sets(rows: Sequence[RecordingRow]) -> Sequence[RecordingRow]:
    """Recordings for the rows of the first paper's Table 4: of the largest sound set of
    each type. If none is there, the first recording."""
    from mocap_metrology.papers.subsets import TABLE_4, standing_for

    columns = ("camera_type", "n_cameras", "twin")
    known = {row.recording: {name: getattr(row, name) for name in columns} for row in rows}
    names = [standing_for(known, *subset) for subset in TABLE_4.items()]
    return named(rows, filter(None, names)) or rows[:1]


def printed(rows: Iterable[RecordingRow], twins: Twins) -> list[RecordingRow]:
    """Twins made from the row of the first paper's tables for their recording."""
    chosen = []
    for row in rows:
        twin = twins[row.twin] if row.twin else None
        source = twin.published if isinstance(twin, Twin) else None
        if source and (source.camera_type, source.n_cameras) == subset(row):
            chosen.append(row)
    return chosen


def on_its_date(twin: AnyTwin | CalibrationTwin, row: SheetRow) -> AnyTwin | CalibrationTwin:
    """The twin of a row; of a facility, on the row's date."""
    if isinstance(twin, Twin) and twin.days and isinstance(row, RecordingRow):
        return replace(twin, date=row.date or "")
    return twin


def form(row: RecordingRow, twins: Twins) -> str | None:
    """Whether the frames of a twin are points or averages; None for a real recording."""
    return twins[row.twin].form if row.twin else None


def subset_of_paper(row: RecordingRow) -> tuple[str, int | None] | None:
    """The subset of a recording of the first paper; None for any other recording."""
    return subset(row) if row.group == "skurowski2019" else None


# Recordings that belong together.


def pairs(rows: Sequence[RecordingRow], accepted: Iterable[str]) -> list[tuple[str, str]]:
    """(recording, reference): the one named by `compare_with`, else the one before by date that was
    accepted, of the same cameras, markers and place. Recordings of one moment are subsets of one
    take, and not compared; takes of a monitor are, with its baseline, by the monitor."""
    known = set(accepted)
    earlier: dict[str, str] = {}
    for alike in _dated_alike([r for r in rows if not r.monitor and r.recording in known]):
        for before, now in pairwise(list(of) for _, of in groupby(alike, _date)):
            earlier |= {row.recording: before[0].recording for row in now}
    compared = [(row.recording, row.compare_with or earlier.get(row.recording)) for row in rows]
    return [(name, reference) for name, reference in compared if reference in known]


def series_over_dates(rows: Sequence[RecordingRow]) -> list[list[str]]:
    """Recordings of the same cameras, markers and place on three days or more, in order of date."""
    return [
        [row.recording for row in alike]
        for alike in _dated_alike(rows)
        if len({_date(row)[:10] for row in alike}) >= 3
    ]


def _date(row: RecordingRow) -> str:
    return row.date or ""


def _dated_alike(rows: Sequence[RecordingRow]) -> list[list[RecordingRow]]:
    """Dated rows of the same cameras, markers (both in any order) and place, in order of date."""
    alike: dict[Any, list[RecordingRow]] = {}
    for row in sorted((row for row in rows if row.date), key=_date):
        same = row.camera_type, row.n_cameras, frozenset(row.camera_ids), frozenset(row.markers)
        alike.setdefault((*same, row.place), []).append(row)
    return list(alike.values())


def takes(rows: Sequence[RecordingRow]) -> list[list[str]]:
    """Recordings of one camera type, date and set of markers, where one has all cameras of another
    and more; those without such a partner are left out."""
    by_take: dict[tuple[str, str | None, tuple[str, ...]], list[RecordingRow]] = {}
    for row in rows:
        by_take.setdefault((row.camera_type, row.date, row.markers), []).append(row)
    nested = [
        [row.recording for row in take if _has_partner(row, take)] for take in by_take.values()
    ]
    return [names for names in nested if names]


def _has_partner(row: RecordingRow, take: Sequence[RecordingRow]) -> bool:
    cameras = frozenset(row.camera_ids)
    others = [frozenset(other.camera_ids) for other in take]
    return any(other and cameras and (cameras < other or other < cameras) for other in others)


# Calibrations.


def decoded_from(row: CalibrationRow) -> dict[str, str]:
    """What a real calibration is decoded from: recording, board, factory calibration, by name."""
    files = {"dump": row.path, "factory": row.factory}
    if row.format != "libsurvive-rec":
        files["board"] = row.board
    return {name: path for name, path in files.items() if path}


def compared_with(row: CalibrationRow) -> dict[str, str]:
    """What the sheet compares a calibration with, tracks its board or places its stations with, by
    name: reference, mount, earlier pose, pose of stations, places in the room."""
    files = {"reference": row.reference, "mount": row.mount, "earlier": row.check_against}
    files |= {"tracked_with": row.tracked_with_file, "points": row.world_points}
    return {name: path for name, path in files.items() if path}


def beside(row: CalibrationRow, rows: Iterable[CalibrationRow]) -> list[CalibrationRow]:
    """Calibrations of other objects of one recording, of a format that names them."""
    if row.twin or row.format != "libsurvive-rec":
        return []
    same = attrgetter("path", "format")
    return [r for r in rows if not r.twin and same(r) == same(row) and r.board != row.board]


def files(row: RecordingRow | CalibrationRow) -> list[str]:
    """All files that a row names."""
    if isinstance(row, RecordingRow):
        return [*([] if row.twin else row.paths), *covariates(row), *references_of(row)]
    decoded = {} if row.twin else decoded_from(row)
    return [*decoded.values(), *compared_with(row).values(), *seen_by(row)]


def batches(rows: Iterable[CalibrationRow]) -> list[list[CalibrationRow]]:
    """Twins that one job simulates and calibrates: those of a setup together, but for what is
    compared or tracked with another, perhaps of the same setup."""
    by_setup: dict[tuple[str, ...], list[CalibrationRow]] = {}
    for row in rows:
        if row.twin:
            single = (row.name,) if row.check_against or row.tracked_with else ()
            by_setup.setdefault((row.group, row.setup, *single), []).append(row)
    return list(by_setup.values())


def shown(rows: Iterable[CalibrationRow]) -> list[CalibrationRow]:
    """Calibrations with a figure; of twins only the first of each setup, unless requested by name:
    they are many, and look alike."""
    first_of: dict[str, CalibrationRow] = {}
    return [row for row in rows if first_of.setdefault(row.setup, row) is row or not row.twin]


def of_generation(
    rows: Iterable[CalibrationRow], twins: Mapping[str, CalibrationTwin], generation: int
) -> list[CalibrationRow]:
    """Twins before stations of one generation."""
    kinds = {1: LighthouseTwin, 2: NetworkTwin}
    return [row for row in rows if row.twin and isinstance(twins[row.twin], kinds[generation])]


def setups(rows: Iterable[CalibrationRow]) -> list[tuple[str, str, str]]:
    """Group, setup and source of what two recordings or more are of; twin if one of them is."""
    sources: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        sources.setdefault((row.group, row.setup), []).append(row.source)
    return [
        (*of, "twin" if "twin" in kinds else "measured")
        for of, kinds in sources.items()
        if len(kinds) > 1
    ]


def first_of_setups(rows: Iterable[CalibrationRow]) -> list[CalibrationRow]:
    """The first calibration of each simulated setup of the second paper."""
    first_of: dict[str, CalibrationRow] = {}
    for row in rows:
        if row.setup.startswith("sim-"):
            first_of.setdefault(row.setup, row)
    return list(first_of.values())


def half_circle(
    rows: Sequence[CalibrationRow], twins: Mapping[str, CalibrationTwin]
) -> Sequence[CalibrationRow]:
    """The one that the figures of the second paper show: its twin on a half circle with the least
    noise, the first of several, or just its first."""
    arcs = [row for row in rows if row.twin and twins[row.twin].motion.pattern == "arc"]
    arcs.sort(key=lambda row: twins[str(row.twin)].independent_urad)
    return [*arcs, *rows][:1]
