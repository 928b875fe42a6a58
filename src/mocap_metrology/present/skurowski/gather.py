"""What a figure or table states of the recordings it shows: where they come from, their length, and
what was cleaned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from mocap_metrology.common.hampel import SHORT_WINDOW, taken_at_most, white_level_kept
from mocap_metrology.common.types import Record
from mocap_metrology.noise.gaussian.moments import expected_moments
from mocap_metrology.noise.series import length_s
from mocap_metrology.noise.twins.twin import Twin
from mocap_metrology.papers.subsets import source_of
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import NINE_HOURS_S, duration_words


def filter_sentence(origin: Record) -> str:
    """Effect of cleaning as in S on the Allan deviations of a table with these metadata."""
    hampel, half = origin["hampel"], origin["window_frames"] // 2
    n_sigma, action = hampel["n_sigma"], hampel["action"]
    if action == "off":
        return ""
    kept = white_level_kept(n_sigma, max(half, SHORT_WINDOW), action)[1]
    most = 100 * taken_at_most(n_sigma, half, action)
    return captions.FILTER.format(n_sigma=n_sigma, percent=100 * (1 - kept**0.5), most=most)


def sources(
    rows: Mapping[str, Record], lengths_s: Mapping[str, float], paper: bool = True
) -> tuple[str, str]:
    """The line at the foot of a figure of these rows of the sheet, and what its caption adds: how
    many are measured, how many are twins of which length, and which.

    lengths_s: by recording; paper: whether the nine hours of S are to compare with.
    """
    twins = [name for name, row in rows.items() if source_of(row) == "twin"]
    lengths: dict[str, list[str]] = {}
    for name in (name for name in twins if name in lengths_s):
        lengths.setdefault(duration_words(lengths_s[name]), []).append(name)
    measured = len(rows) - len(twins)
    kinds = [f"{measured} measured recording{'s' * (measured > 1)}"] if measured else []
    if twins:
        many, of = "s" * (len(twins) > 1), f" of {' and '.join(lengths)}" if lengths else ""
        kinds.append(f"{len(twins)} simulated stand-in{many} (twin{many}){of}")
    line = f"Source: {' and '.join(kinds)}."
    if paper and lengths and list(lengths) != [duration_words(NINE_HOURS_S)]:
        line += " The paper's recordings last nine hours."
    remarks = ["Twins are simulated from published or configured numbers."] if twins else []
    if twins and measured:
        remarks.append(f"Simulated: {', '.join(twins)}; the others are measured.")
    if len(lengths) > 1:
        each = "; ".join(f"{', '.join(names)}: {length}" for length, names in lengths.items())
        remarks.append(f"Length of the twins: {each}.")
    return line, " ".join(remarks)


def sources_of(origins: Mapping[str, Record]) -> tuple[str, str]:
    """The same of recordings of any group, by metadata of a table of each."""
    return sources(origins, {name: length_s(of) for name, of in origins.items()}, paper=False)


def spread_sentence(twin: Twin | None) -> str:
    """Why the spread of a twin of Figure 9 is not Table 4's: its length and its coefficients."""
    if twin is None:
        return ""
    spread = []
    for seconds in (twin.duration_s, NINE_HOURS_S):
        moments = expected_moments(replace(twin, duration_s=seconds))
        one, two = (f"{1000 * moments[f'sigma_{k}']:.1f}" for k in (1, 2))
        spread.append(f"{one} and {two} µm over {duration_words(seconds)}")
    return captions.SPREAD.format(spread=", ".join(dict.fromkeys(spread)))


def gaussian_row(rows: Sequence[Row], axis: str) -> Row:
    """The first row of gaussian.csv along that axis, else the first row."""
    return next((row for row in rows if row["axis"] == axis), rows[0] if rows else {})
