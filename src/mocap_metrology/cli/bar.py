"""`mocap-metrology check --bar`: how wrong a length is while it moves through the volume."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from mocap_metrology.accuracy.bar import BarEntry
from mocap_metrology.accuracy.statistics import FEWEST
from mocap_metrology.cli import results
from mocap_metrology.cli.recording import SETTINGS, advised, reuse_freed_memory
from mocap_metrology.common.errors import Refusal
from mocap_metrology.present.accuracy.bar import bar_lines
from mocap_metrology.present.text.numbers import duration_words
from mocap_metrology.recording import bar
from mocap_metrology.recording.clean import Entry


def check_bar(path: Path, folder: Path, options: argparse.Namespace) -> str:
    """Results of one take of a bar into the folder, the verdict on the terminal; its word."""
    reuse_freed_memory()
    truncated, columns = options.accept_truncated, options.columns
    entry = Entry([str(path)], [], options.rate, truncated, options.unit, column_names=columns)
    bar_row = BarEntry(options.bar, options.length, options.length_u)
    named = {"recording": results.name_of(path), "source": "measured", "twin": None}
    try:
        reading = bar.read_bar(entry, bar_row, SETTINGS, named)
        take = reading.take
        n, rate = take.length_mm.size, take.frame_rate_hz
        pair = " and ".join(reading.pair)
        results.tell(f"{pair}: {n} frames at {rate:g} Hz, {duration_words(n / rate)}")
        with results.replaced(folder, bar.FILES) as part:
            bar.write_take(reading, bar_row, part / bar.TAKE)
            document = bar.write_bar(part, SETTINGS)
    except Refusal as refusal:
        raise Refusal(advised(refusal)) from None
    lines = bar_lines(document)
    shown = (
        [": ".join(lines[:2])] if options.brief else [*lines, "", f"Figure: {folder / 'bar.png'}"]
    )
    results.tell_result(shown)
    return str(document["word"])


def tell_together(folders: Sequence[Path]) -> None:
    """What takes of one bar show together, from three on with intervals."""
    if len(folders) < FEWEST:
        return
    paths = [folder / bar.TAKE for folder in folders]
    results.tell_result(
        line for one in bar.passes_of(paths, SETTINGS) for line in ("", *bar_lines(one.document))
    )
