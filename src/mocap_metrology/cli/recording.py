"""`mocap-metrology check` of a recording of markers, by those named or by the first two at rest."""

from __future__ import annotations

import argparse
import ctypes
import logging
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from mocap_metrology.cli import results
from mocap_metrology.common.errors import Refusal, Unseen
from mocap_metrology.io.labels import find_points, in_words
from mocap_metrology.io.read import Kind, labels_of, points_by_kind
from mocap_metrology.io.recording import GIVE_RATE, Recording
from mocap_metrology.io.text.table import HOW
from mocap_metrology.noise.gaussian.two_markers import median_drift
from mocap_metrology.present.text.numbers import duration_words, mm
from mocap_metrology.present.verdict.words import verdict_lines
from mocap_metrology.recording import analyse, clean
from mocap_metrology.recording.clean import Check, Entry
from mocap_metrology.recording.progress import ProgressLines
from mocap_metrology.settings import Noise, Settings

# One estimator of noise decides the verdict; the others are for comparison
SETTINGS = Settings(noise=Noise(estimators=("likelihood",)))
# What is judged, the first kind of which the file has points, and what to say of it
KINDS: dict[Kind, str] = {
    "marker": "",
    "unlabelled": "; no marker of the file has a label, so a trajectory may be of several",
    "body": "; they are rigid bodies, whose positions the software solved from several markers",
}
FEWEST_SEEN = 0.5  # share of frames a marker must be there in to be chosen
MOVING = "no two are at rest"
WANTED = 2  # with two there is a distance
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD, M_ARENA_MAX = -1, -3, -8  # of glibc's malloc.h
LARGEST = 1 << 29  # bytes of an array, and of what is kept


def check_recording(path: Path, folder: Path, options: argparse.Namespace) -> str:
    """Results of one recording into the folder, the verdict on the terminal; its word."""
    reuse_freed_memory()
    progress = ProgressLines(sys.stderr, analyse.N_STEPS, options.threads or processors())
    log = logging.getLogger("mocap_metrology")
    log.addHandler(progress)
    name = results.name_of(path)
    try:
        entry = _entry(path, options)
        with results.replaced(folder, analyse.FILES) as part:
            verdict = analyse.analyse(entry, name, part, SETTINGS, tell, progress)
    except Refusal as refusal:
        raise Refusal(advised(refusal)) from None
    finally:
        log.removeHandler(progress)
    lines = verdict_lines(verdict)
    pictures = (f"  {folder / f'{figure}.png'}" for figure in analyse.PICTURES)
    word = str(verdict["word"])
    short = [f"{folder.name}: {word}: {lines[1]}"]  # of several files of one name
    results.tell_result(short if options.brief else [*lines, "", "Figures:", *pictures])
    return word


def tell(checked: Check, recording: Recording) -> None:
    """What is analysed, and what to beware of."""
    n_frames, rate = recording.position_mm.shape[2], recording.frame_rate_hz
    labels, length = ", ".join(recording.labels), duration_words(n_frames / rate)
    for words in (f"{labels}: {n_frames} frames at {rate:g} Hz, {length}", *checked["warnings"]):
        results.tell(words)


def reuse_freed_memory() -> None:
    """Have glibc, where it is, use the memory of freed arrays again. The kernel clears all that it
    gives anew, which took a fourteenth of the time of nine hours."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None and mallopt(M_MMAP_THRESHOLD, LARGEST):
        mallopt(M_TRIM_THRESHOLD, LARGEST)
        mallopt(M_ARENA_MAX, 1)  # another thread's own holds no large array


def processors() -> int:
    """How many this process may use; macOS has no affinity, and all."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


def _entry(path: Path, options: argparse.Namespace) -> Entry:
    """The entry of a file with the named markers, or with a choice of markers, which is
    reported."""
    named = [part.strip() for text in options.markers for part in text.split(";") if part.strip()]
    truncated, columns = options.accept_truncated, options.columns
    entry = Entry([str(path)], named, options.rate, truncated, options.unit, column_names=columns)
    if named:
        find_points(labels_of(path, truncated, columns), named, path.name)
        return entry
    markers, why = chosen(entry, SETTINGS.still.range_mm)
    what = f"{', '.join(markers)} ({why}); name others with --markers, in make MARKERS="
    if MOVING in why:
        what += ", or check a rigid pair that moves with --bar A-B or auto, in make BAR="
    results.tell(f"Markers: {what}")
    return replace(entry, markers=markers)


def advised(refusal: Refusal) -> str:
    """The refusal, and what to write on the command line."""
    rate = ", here --rate 100, in make RATE=100"
    truncated = "add --accept-truncated, in make TRUNCATED=accept"
    unit = "--unit m or mm, in make UNIT=m or mm"
    why = clean.refused(refusal, truncated, unit)["why"]
    names = ', here --columns "t x y z", in make NAMES="t x y z"'
    return why.replace(GIVE_RATE, GIVE_RATE + rate).replace(HOW, HOW + names)


def chosen(entry: Entry, limit_mm: float, wanted: int = WANTED) -> tuple[list[str], str]:
    """Markers of a file, so many at most, by which it is judged where none are named, and why
    these."""
    (path,) = entry.paths
    points = points_by_kind(path, entry.accept_truncated, entry.column_names)
    for kind in (kind for kind in KINDS if kind in points):
        labels = [label for label in points[kind] if ";" not in label]
        unfit = in_words([label for label in points[kind] if label not in labels])
        out = f"; not {unfit}: a label with a ; cannot be named, rename it" if unfit else ""
        movement = partial(_movement, entry, [])
        markers, why = choose(labels, movement, limit_mm, wanted)
        if markers:
            return markers, why + KINDS[kind] + out
    why = "all its points were computed by a model, not measured; to use them all the same, name"
    if KINDS.keys() & points.keys():
        why = "no marker or body is seen in half of the frames (one with a coordinate that is 0"
        why += " throughout was not measured); name markers of these"
    every = in_words([label for labels in points.values() for label in labels], 60)
    raise Refusal(f"{Path(path).name}: {why}: {every}")


def choose(
    labels: Sequence[str],
    movement: Callable[[str], float | None],
    limit_mm: float,
    wanted: int = WANTED,
) -> tuple[list[str], str]:
    """Markers to judge by, and why these.

    The first in the file that are at rest, so many as are wanted: choosing the quietest would
    flatter the system. Where fewer than two do, the two that move least. movement: range in mm of
    a marker's one-second means, None if it is hardly visible or not measured; computed only until
    enough are found.
    """
    ranges: dict[str, float] = {}
    still: list[str] = []
    for label in labels:
        moved = movement(label)
        if moved is not None:
            ranges[label] = moved
        still = [name for name, value in ranges.items() if value <= limit_mm]
        if len(still) == wanted:
            return still, "the first two at rest"
    if len(still) >= WANTED:
        return still, f"all {len(still)} at rest of {len(labels)}"
    least = sorted(ranges, key=lambda name: ranges[name])[:WANTED]
    if least and ranges[least[-1]] <= limit_mm:
        return least, "all at rest"
    moves = ", ".join(f"{name} by {mm(ranges[name])}" for name in least)
    return least, f"those that move least, {moves}: {MOVING}"


def _movement(entry: Entry, others: list[np.ndarray], label: str) -> float | None:
    """Range of a marker's one-second medians in mm; None if it is hardly seen, or has a coordinate
    that is zero or three that are equal throughout, which no marker has that is measured, or is one
    of the others under another label; else it is added to them."""
    try:
        recording = clean.read(replace(entry, markers=[label]), second_opinion=False)
    except Unseen:
        return None
    position = recording.position_mm[0]
    seen = np.isfinite(position).all(axis=0)
    known = position if seen.all() else position[:, seen]
    if seen.mean() < FEWEST_SEEN or not known.any(axis=1).all() or (known == known[0]).all():
        return None
    rate = recording.frame_rate_hz
    ranges = [median_drift(axis.astype(float), rate).range for axis in position]
    some = clean.some_frames(position)
    if not np.isfinite(ranges).all() or any(clean.are_one(some, one) for one in others):
        return None
    others.append(some)
    return float(max(ranges))
