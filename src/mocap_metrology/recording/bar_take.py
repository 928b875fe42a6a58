"""A take of a bar, read from a recording or a twin, or why it says nothing of a bar."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.accuracy import take as of_take
from mocap_metrology.accuracy.bar import BarEntry
from mocap_metrology.accuracy.clusters import ScaleSlope, rigid_clusters, scale_slope
from mocap_metrology.accuracy.take import Take, take_of, with_angles
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Row
from mocap_metrology.io.labels import AUTO, in_words, pair_of
from mocap_metrology.io.read import bodies_of, orientation_of, points_by_kind
from mocap_metrology.present.text.sentence import render
from mocap_metrology.recording.clean import Check, Entry, accepted, read, trajectories
from mocap_metrology.settings import Settings

MOST_REPEATED = 0.01  # of the frames in which a bar moves


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
        take = with_angles(take, _quaternions(entry, pair), pose.quaternion if pose else None)
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


def _quaternions(entry: Entry, pair: Sequence[str]) -> np.ndarray:
    told = entry.frame_rate_hz, entry.accept_truncated, entry.column_names
    return np.array([orientation_of(entry.paths, body, *told) for body in pair])
