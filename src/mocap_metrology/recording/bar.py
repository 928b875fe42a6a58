"""The steps of a recording whose bar is moved: its takes are read, judged, written and drawn."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.accuracy import bar_rows
from mocap_metrology.accuracy import take as of_take
from mocap_metrology.accuracy.bar import Bar, BarEntry, Certificate, evaluate
from mocap_metrology.accuracy.clusters import ScaleSlope, rigid_clusters, scale_slope
from mocap_metrology.accuracy.findings import findings_of
from mocap_metrology.accuracy.take import Take, take_of, with_angles
from mocap_metrology.common import files
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.gum import Component
from mocap_metrology.common.types import Row
from mocap_metrology.io.labels import AUTO, in_words, pair_of
from mocap_metrology.io.read import bodies_of, orientation_of, points_by_kind
from mocap_metrology.noise import filters
from mocap_metrology.present import tables
from mocap_metrology.present.accuracy import bar as present
from mocap_metrology.present.accuracy import statement
from mocap_metrology.present.accuracy.bar import bar_figure
from mocap_metrology.present.accuracy.statement import save_page, statement_page
from mocap_metrology.present.plot.figure import Texts, save
from mocap_metrology.present.recording import source_words
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.sentence import render
from mocap_metrology.recording.clean import Check, Entry, accepted, read, trajectories
from mocap_metrology.settings import Settings

COLUMNS = ("length_mm", "x_mm", "y_mm", "z_mm", "along_x", "along_y", "along_z")
TAKE = "bar.parquet"
MOST_REPEATED = 0.01  # of the frames in which a bar moves
FILES = (
    *("bar.json", "bar.csv", "bar_places.csv", TAKE, "bar.svg", "bar.png"),
    *("noise_ros.yaml", "px4.params"),
)


@dataclass(frozen=True)
class Reading:
    """One take, its two ends, the rigid clusters (of `auto`) and the scale along the way; check:
    contents of check.json of a recording that was measured."""

    take: Take
    pair: tuple[str, str]
    origin: Mapping[str, Any]
    clusters: Sequence[Row] = ()
    scale: ScaleSlope | None = None
    warnings: Sequence[str] = ()
    check: Check | None = None


def read_bar(
    entry: Entry, bar_row: BarEntry, settings: Settings, named: Mapping[str, Any]
) -> Reading:
    """The take of a recording; named: `recording`, `source`, `twin`, `date`. Refuses what says
    nothing of a bar."""
    pose, check = bar_row.pose, None
    file = str(named["recording"]) if named.get("twin") else Path(entry.paths[0]).name
    entry = replace(entry, markers=_markers(entry, bar_row.bar, file))
    opinion = settings.second_opinion and not named.get("twin")
    recording = read(entry, opinion, only_seen=bar_row.bar == AUTO)
    if not named.get("twin"):
        check = accepted(entry, recording, True, [])
    raw = trajectories(recording, {**named, "pairs": None})
    labels, origin = list(raw.origin["labels"]), raw.origin
    position = np.array([values for _, values in raw.in_mm()]).reshape(len(labels), 3, -1)

    def take_by(ends: Sequence[int]) -> Take:
        date = str(named.get("date") or "")[:10]
        told = str(named["recording"]), date, origin["frame_rate_hz"]
        return take_of(*told, position[list(ends)], origin["resolution_mm"])

    far, clusters = settings.bar.least_path_mm, []
    if bar_row.bar == AUTO:
        rigid = rigid_clusters(position, settings.bar.rigid_mm)
        clusters = [one for one in rigid if of_take.way_mm(take_by(one.pair)) >= far]
        if not clusters:
            limit = f"(p97.5 - p2.5) / 4 below {settings.bar.rigid_mm:g} mm, bar.rigid_mm"
            what = f"has no two markers that stay at one distance ({limit}) and move {far:g} mm"
            raise Refusal(f"{file}: {what}; name a bar of the file: {in_words(labels, 60)}")
        first, second = clusters[0].pair
    else:
        first, second = map(labels.index, pair_of(bar_row.bar, labels, file))
    pair, take = (labels[first], labels[second]), take_by((first, second))
    of_take.check(replace(take, name=file), " and ".join(pair), bar_row.length_mm, far)
    bodies = () if named.get("twin") else bodies_of(entry.paths[0], None, entry.column_names)
    if set(pair) <= set(bodies):
        told = entry.frame_rate_hz, entry.accept_truncated, entry.column_names
        turns = np.array([orientation_of(entry.paths, body, *told) for body in pair])
        take = with_angles(take, turns, pose.quaternion if pose else None)
    elif pose:
        raise Refusal(f"{file}: bar_pose is for two bodies; {' and '.join(pair)} are markers")
    shown: list[Row] = [
        {**asdict(one), "labels": [labels[k] for k in one.markers]} for one in clusters
    ]
    scale = scale_slope(position, clusters[0].markers) if clusters else None
    warnings = [
        *(check["warnings"] if check else ()),
        *_warnings(take, pair, settings.bar.rigid_mm),
    ]
    return Reading(take, pair, origin, shown, scale, warnings, check)


def _warnings(take: Take, pair: tuple[str, str], rigid_mm: float) -> list[str]:
    said = []
    if turned := of_take.reversals(take):
        said.append(render("bar.reversals", n=turned, pair=pair))
    if (share := of_take.repeated_frames(take)) > MOST_REPEATED:
        said.append(render("bar.repeated", share=share))
    median = float(np.median(take.length_mm[take.known]))
    off = np.nan_to_num(np.abs(take.length_mm - median))
    if (gross := np.flatnonzero(off > of_take.MOST_SPREAD * median)).size:
        at_s, largest = float(gross[0] / take.frame_rate_hz), float(off.max())
        said.append(render("bar.gross", n=gross.size, at_s=at_s, largest=largest, pair=pair))
    if one := of_take.change(take):
        said.append(render("bar.change", **asdict(one), pair=pair))
    if (spread := of_take.spread_mm(take)) > rigid_mm:
        said.append(render("bar.loose", spread=spread, limit=rigid_mm, pair=pair))
    return said


def _markers(entry: Entry, bar: str, file: str) -> list[str]:
    """The first kind of points of the file, or the two that are named."""
    kinds = points_by_kind(entry.paths[0], entry.accept_truncated, entry.column_names)
    if bar != AUTO:
        return list(pair_of(bar, [one for labels in kinds.values() for one in labels], file))
    return list(next(iter(kinds.values()), ()))


def write_take(reading: Reading, bar_row: BarEntry, path: Path) -> None:
    """bar.parquet: a take frame by frame, and what else was read of it."""
    take, pose = reading.take, bar_row.pose
    record = {**reading.origin, "date": take.date, "pair": reading.pair}
    record |= {"length_mm": bar_row.length_mm, "length_u_mm": bar_row.length_u_mm}
    record |= {"angle_bias_deg": None if math.isnan(take.angle_bias_deg) else take.angle_bias_deg}
    record |= {"pose_u_deg": pose.u_deg if pose else 0.0, "warnings": reading.warnings}
    record |= {"clusters": reading.clusters, "scale": reading.scale and asdict(reading.scale)}
    axes = zip(COLUMNS, (take.length_mm, *take.middle_mm, *take.direction), strict=True)
    angle = {} if take.angle_deg is None else {"angle_deg": take.angle_deg}
    files.write_table(path, dict(axes) | angle, record)


def read_take(path: str | Path) -> tuple[Take, Mapping[str, Any]]:
    """A take out of bar.parquet, and its origin."""
    columns, origin = files.read_table(path)
    length, *others = (columns[name] for name in COLUMNS)
    bias = origin["angle_bias_deg"]
    take = Take(
        origin["recording"],
        origin["date"],
        origin["frame_rate_hz"],
        length,
        np.array(others[:3]),
        np.array(others[3:]),
        origin["resolution_mm"],
        columns.get("angle_deg"),
        math.nan if bias is None else bias,
    )
    return take, origin


def write_bar(folder: Path, settings: Settings) -> Mapping[str, Any]:
    """Results of the take in the folder: bar.json, bar.csv, bar_places.csv, the figure, noise for
    filters; the contents of bar.json."""
    take, origin = read_take(folder / TAKE)
    bar = evaluate([take], _certificate(origin), settings.bar)
    scale = ScaleSlope(**origin["scale"]) if origin["scale"] else None
    findings = findings_of(bar, scale, pose_u_deg=origin["pose_u_deg"])
    told = {"scale": scale, "clusters": origin["clusters"], "warnings": origin["warnings"]}
    document: Row = {"recording": take.name, "source": origin["source"], "twin": origin["twin"]}
    document |= {"frame_rate_hz": take.frame_rate_hz}
    document |= {"duration_s": take.length_mm.size / take.frame_rate_hz}
    document |= present.bar_document(bar, findings, settings.bar, origin["pair"], **told)
    files.write_csv(folder / "bar.csv", bar_rows.bar_rows(bar))
    places = bar_rows.place_rows(bar, settings.place.cell_mm)
    files.write_csv(folder / "bar_places.csv", places, bar_rows.PLACES)
    texts = Texts(f"{take.name}: length of the bar", f"Source: {source_words(origin)}.")
    save(bar_figure(bar, settings.place.cell_mm, settings.bar, texts), folder / "bar")
    _write_filters(folder, document, bar)
    files.write_json(folder / "bar.json", document)
    return dict(files.read_json(folder / "bar.json"))


def _certificate(origin: Mapping[str, Any]) -> Certificate | None:
    length = origin["length_mm"]
    return None if length is None else Certificate(length, origin["length_u_mm"] or 0.0)


def _write_filters(folder: Path, document: Row, bar: Bar) -> None:
    """noise_ros.yaml, px4.params: the variance of the rest is that of both ends along the bar, of
    which each axis of an end gets half."""
    rest = max(one.parts["rest"].value for one in bar.classes) / math.sqrt(2)
    middle = np.concatenate([take.middle_mm[:, take.known] for take in bar.takes], axis=1)
    series = {f"{axis}{k}": {"frame_mm": rest} for axis in "xyz" for k in (1, 2)}
    of = document | {"labels": document["pair"], "series": series}
    of["horizon_s"] = document["duration_s"]
    covariances = filters.covariances(of, np.array([middle.mean(axis=1)] * 2))
    files.write_text(folder / "noise_ros.yaml", filters.ros_yaml(of, covariances, filters.OF_BAR))
    files.write_text(folder / "px4.params", filters.px4_params(of, covariances))


@dataclass(frozen=True)
class BarGroup:
    """All passes of one bar, and sources of the recordings by name; document: as bar.json."""

    bar: Bar
    pair: Sequence[str]
    sources: Mapping[str, str]
    document: Row


def passes_of(
    paths: Iterable[str | Path], settings: Settings, still_mm: float | None = None
) -> list[BarGroup]:
    """The bars of some bar.parquet, those of most passes first: takes with one pair of markers and
    one certificate are passes of one bar. The same files count once."""
    bars: dict[tuple[Any, ...], list[tuple[Take, Mapping[str, Any]]]] = {}
    first: dict[tuple[Any, ...], str] = {}
    twice: dict[tuple[Any, ...], list[str]] = {}
    for take, origin in map(read_take, paths):
        key = (*sorted(origin["pair"]), origin["length_mm"], origin["length_u_mm"])
        sums = tuple(segment["sha256"] for segment in origin["segments"])
        known = first.setdefault((*key, *sums), take.name) if not origin["twin"] else take.name
        if known != take.name:
            said = render("bar.twice", name=take.name, known=known)
            twice.setdefault(key, []).append(said)
            continue
        bars.setdefault(key, []).append((take, origin))
    groups = []
    for key, of_pair in sorted(bars.items(), key=lambda one: -len(one[1])):
        pair, told = of_pair[0][1]["pair"], twice.get(key, ())
        bar = evaluate([take for take, _ in of_pair], _certificate(of_pair[0][1]), settings.bar)
        findings = findings_of(bar, still_mm=still_mm)
        passes = "1 pass" if len(of_pair) == 1 else f"{len(of_pair)} passes"
        named: Row = {"recording": f"{passes} of {'-'.join(pair)}"}
        document = named | present.bar_document(bar, findings, settings.bar, pair, warnings=told)
        sources = {origin["recording"]: origin["source"] for _, origin in of_pair}
        groups.append(BarGroup(bar, pair, sources, document))
    return groups


def write_group(
    group: str,
    paths: Iterable[str | Path],
    still: Iterable[Mapping[str, Any]],
    settings: Settings,
    path: Path,
    figure: Path,
) -> BarGroup:
    """Passes of a group together: tables beside the JSON file `path`, and the figure of the bar
    with most passes, which is returned. still: contents of verdict.json of the group's
    recordings."""
    still_mm = bar_rows.noise_at_rest(still)
    bars = passes_of(paths, settings, still_mm)
    sources = {name: source for one in bars for name, source in one.sources.items()}
    of = tables.source_sentence(sources)
    rows = [
        {"bar": "-".join(one.document["pair"])} | row  # type: ignore[arg-type]
        for one in bars
        for row in bar_rows.bar_rows(one.bar)
    ]
    said = " ".join((captions.BAR_TABLE, *present.bar_words([one.document for one in bars]), of))
    tables.write(path.with_suffix(".csv"), rows, f"{group}: length of a bar that moves", said)
    files.write_json(path, {"bars": [one.document for one in bars]})
    drawn = bars[0].bar
    texts = Texts(f"{group}: length of the bar, {len(drawn.takes)} passes", of)
    save(bar_figure(drawn, settings.place.cell_mm, settings.bar, texts, still_mm), figure)
    return bars[0]


def write_statement(
    group: str, one: BarGroup, known: Sequence[Component], path: Path, pdf: Path
) -> None:
    """Statement of uncertainty by a bar and what is known otherwise: tables beside the JSON file
    `path`, the page as `pdf` and as PNG."""
    document = statement.statement_document(one.bar, one.pair, known)
    of = tables.source_sentence(one.sources)
    said = "\n\n".join((statement.statement_words(document), f"{captions.STATEMENT} {of}"))
    title = f"{group}: statement of uncertainty"
    tables.write(path.with_suffix(".csv"), statement.statement_rows(document), title, said)
    files.write_json(path, {"group": group, **document})
    save_page(statement_page(document, group, of), pdf)
