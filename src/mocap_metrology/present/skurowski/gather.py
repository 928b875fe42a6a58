"""What Figures 6, 9-11 and 14-17 of S show, from the sheet, gaussian.csv and the twins:
recordings, series, titles, and how long twins are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from mocap_metrology.common.hampel import SHORT_WINDOW, taken_at_most, white_level_kept
from mocap_metrology.noise.gaussian.moments import expected_moments
from mocap_metrology.noise.twins.published import published_gaussian
from mocap_metrology.noise.twins.twin import Twin
from mocap_metrology.present.skurowski.camera_tables import TABLE_4, standing_for
from mocap_metrology.present.skurowski.densities import Mean
from mocap_metrology.present.skurowski.scaling import Subset
from mocap_metrology.present.tables import Record, Row, source_of
from mocap_metrology.present.text.captions import PAPER
from mocap_metrology.present.text.numbers import NINE_HOURS_S, duration_words

TITLES = {
    6: f"{PAPER}, Figure 6: weighted and ordinary least squares",
    14: f"{PAPER}, Figure 14: colour noise coefficients, logarithmic",
    15: f"{PAPER}, Figure 15: colour noise coefficients, linear",
    16: f"{PAPER}, Figure 16: correlated noise",
    17: f"{PAPER}, Figure 17: a periodic disturbance, in spectra of z1",
}
LINE_HZ = 14.4  # S's "15 Hz": eight rows of Tables A1-A3 have 13.7 to 14.4 Hz
SERIES = "z1"  # of Figures 6 and 17; S names none for 6, this one has a line and three bumps


def largest(recordings: Mapping[str, Record]) -> dict[str, str]:
    """Label (camera type, cameras) and recording of the largest sound subset of each type."""
    found = {}
    for kind in ("T40", "Bonita", "Vantage"):
        name = standing_for(recordings, kind, TABLE_4[kind])
        if name is not None:
            found[f"{kind} ({TABLE_4[kind]})"] = name
    return found


def of_regression(recordings: Mapping[str, Record]) -> str:
    """The recording of Figure 6: all T40 cameras, or else the first there is."""
    return standing_for(recordings, "T40", 10) or next(iter(recordings))


NOT_FITTED = ("Vantage", 10)  # with the failing camera (S 3.5)
EXPECTED = {"sigma_1_mm": "sigma_1", "sigma_2_mm": "sigma_2", "sigma_L_mm": "sigma_L"}


def length_s(origin: Record) -> float:
    """Length of a recording in s, with its gaps, by the metadata of one of its tables."""
    frames = sum(s["n_frames"] + max(s["gap_before"], 0) for s in origin["segments"])
    return float(frames / origin["frame_rate_hz"])


def filter_sentence(origin: Record) -> str:
    """Effect of cleaning as in S on the Allan deviations of a table with these metadata."""
    given, half = origin["hampel"], origin["window_frames"] // 2
    if given["action"] == "off":
        return ""
    kept = white_level_kept(given["n_sigma"], max(half, SHORT_WINDOW), given["action"])[1]
    most = 100 * taken_at_most(given["n_sigma"], half, given["action"])
    return (
        f"Cleaned as in the paper: the {given['n_sigma']:g}-sigma filter lowers the deviation of "
        f"white noise by {100 * (1 - kept**0.5):.2g} %, and by at most {most:.2g} % where slow "
        "noise lies below it; the upper ends of intervals are raised by that."
    )


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


def spread_sentence(twin: Twin | None) -> str:
    """Why the spread of a twin of Figure 9 is not Table 4's: its length and its coefficients."""
    if twin is None:
        return ""
    spread = []
    for seconds in dict.fromkeys((twin.duration_s, NINE_HOURS_S)):
        found = expected_moments(replace(twin, duration_s=seconds))
        one, two = (f"{1000 * found[f'sigma_{k}']:.1f}" for k in (1, 2))
        spread.append(f"{one} and {two} µm over {duration_words(seconds)}")
    return (
        "Slow noise widens a density with time: the standard deviations that the printed "
        f"coefficients lead to on average are {', '.join(spread)}, for x1 and x2; those of Table "
        "4 refer to nine hours."
    )


def gaussian_row(rows: Sequence[Row], axis: str) -> Row:
    """Of gaussian.csv: the first row along that axis, else the first there is."""
    return next((row for row in rows if row["axis"] == axis), rows[0] if rows else {})


def of_locations(sheet: Mapping[str, Record], names: Sequence[str]) -> str:
    """The recording of Figure 9 among some: the T40 cameras, as in S, or else the first."""
    return next((name for name in names if sheet[name]["camera_type"] == "T40"), names[0])


def means(
    sheet: Mapping[str, Record],
    gaussian: Mapping[str, Mapping[str, float]],
    twins: Mapping[str, Twin],
) -> list[Mean]:
    """Mean of L of every recording that has one, in the order of the sheet."""
    found = []
    for name, row in sheet.items():
        value = gaussian[name].get("mu_L_mm")
        if value is None or value != value:
            continue
        error = expected_moments(twins[name])["mu_L"] if name in twins else None
        kind = row["camera_type"]
        printed = published_gaussian(kind)["mu_L_mm"] if kind in TABLE_4 else None
        found.append(Mean(kind, row["n_cameras"], float(value), error, printed))
    return found


def subsets(
    sheet: Mapping[str, Record],
    gaussian: Mapping[str, Mapping[str, float]],
    twins: Mapping[str, Twin],
) -> list[Subset]:
    """S Figure 11 from the paper's recordings: types of which there are several subsets."""
    found = []
    for name, row in sheet.items():
        key = row["camera_type"], row["n_cameras"]
        expected: dict[str, float] = {}
        if name in twins:
            moments = expected_moments(twins[name])
            expected = {k: moments[v] for k, v in EXPECTED.items()}
            expected["sigma_12_mm2"] = moments["sigma_12"]
        printed = published_gaussian(key[0]) if TABLE_4.get(key[0]) == key[1] else {}
        found.append(Subset(*key, gaussian[name], expected, printed, key != NOT_FITTED))
    return _several(found)


def subsets_of_group(
    sheet: Mapping[str, Record], gaussian: Mapping[str, Mapping[str, float]]
) -> list[Subset]:
    """The same of any group, without what only the paper has."""
    return _several(
        [
            Subset(row["camera_type"] or "", row["n_cameras"], gaussian[name])
            for name, row in sheet.items()
            if row["n_cameras"] and gaussian[name]
        ]
    )


def _several(found: Sequence[Subset]) -> list[Subset]:
    """Of camera types with two different numbers of cameras at least."""
    counts: dict[str, set[int]] = {}
    for subset in found:
        counts.setdefault(subset.camera_type, set()).add(subset.n_cameras)
    return [subset for subset in found if len(counts[subset.camera_type]) > 1]
