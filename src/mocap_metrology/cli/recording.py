"""`mocap-metrology check` of a recording of markers."""

from __future__ import annotations

import argparse
import ctypes
import logging
import os
import sys
from dataclasses import replace
from pathlib import Path

from mocap_metrology.cli.markers import chosen
from mocap_metrology.cli.results import name_of, replaced, tell, tell_result
from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.labels import find_points
from mocap_metrology.io.read import labels_of
from mocap_metrology.io.recording import Recording
from mocap_metrology.io.text.table import HOW
from mocap_metrology.present.text.numbers import duration_words
from mocap_metrology.present.verdict.words import verdict_lines
from mocap_metrology.recording.analyse import FILES, N_STEPS, PICTURES, analyse
from mocap_metrology.recording.clean import Check, Entry, refused
from mocap_metrology.recording.progress import Shown
from mocap_metrology.settings import Noise, Settings

# One estimator of noise decides the verdict; the others are for comparison
SETTINGS = Settings(noise=Noise(estimators=("likelihood",)))
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD, M_ARENA_MAX = -1, -3, -8  # of glibc's malloc.h
LARGEST = 1 << 29  # bytes of an array, and of what is kept


def check_recording(path: Path, folder: Path, given: argparse.Namespace) -> None:
    """Results of one recording into the folder, and the verdict on the terminal."""
    keep_freed_memory()
    progress = Shown(sys.stderr, N_STEPS, given.threads or processors())
    log = logging.getLogger("mocap_metrology")
    log.addHandler(progress)
    try:
        entry = _entry(path, given)
        with replaced(folder, FILES) as part:
            verdict = analyse(entry, name_of(path), part, SETTINGS, _tell, progress)
    except Refusal as refusal:
        raise Refusal(_why(refusal)) from None
    finally:
        log.removeHandler(progress)
    if given.brief:
        tell_result([": ".join(verdict_lines(verdict)[:2])])
        return
    pictures = (f"  {folder / f'{name}.png'}" for name in PICTURES)
    tell_result([*verdict_lines(verdict), "", "Figures:", *pictures])


def _tell(check: Check, recording: Recording) -> None:
    """What is analysed, and what to beware of."""
    n_frames, rate = recording.position_mm.shape[2], recording.frame_rate_hz
    labels = ", ".join(recording.labels)
    tell(f"{labels}: {n_frames} frames at {rate:g} Hz, {duration_words(n_frames / rate)}")
    for words in check["warnings"]:
        tell(words)


def keep_freed_memory() -> None:
    """Have glibc, where it is, use the memory of freed arrays again. The kernel clears all that it
    gives anew, which took a fourteenth of the time of nine hours."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is None or not mallopt(M_MMAP_THRESHOLD, LARGEST):
        return
    mallopt(M_TRIM_THRESHOLD, LARGEST)
    mallopt(M_ARENA_MAX, 1)  # another thread's own holds no large array


def processors() -> int:
    """How many this process may use; macOS has no affinity, and all."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


def _entry(path: Path, given: argparse.Namespace) -> Entry:
    """With the named markers, or a choice of markers, which is reported."""
    named = [part.strip() for text in given.markers for part in text.split(";") if part.strip()]
    entry = Entry(
        [str(path)],
        named,
        given.rate,
        given.accept_truncated,
        given.unit,
        column_names=given.columns,
    )
    if named:
        find_points(labels_of(path, entry.accept_truncated, entry.column_names), named, path.name)
        return entry
    found, why = chosen(entry, SETTINGS.still.range_mm)
    tell(f"Markers: {', '.join(found)} ({why}); name others with --markers, in make MARKERS=")
    return replace(entry, markers=found)


def _why(refusal: Refusal) -> str:
    """The refusal, and what to write on the command line."""
    rate = ", here --rate 100, in make RATE=100" if "column frame_rate_hz" in str(refusal) else ""
    why = refused(
        refusal,
        "add --accept-truncated, in make TRUNCATED=accept",
        "--unit m or mm, in make UNIT=m or mm",
    )["why"]
    names = ', here --columns "t x y z", in make NAMES="t x y z"' if HOW in why else ""
    return f"{why}{rate}{names}"
