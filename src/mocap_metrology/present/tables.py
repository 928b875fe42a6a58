"""Tables: each as CSV with full digits and as Markdown with a caption, to read."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.common.files import write_csv, write_text
from mocap_metrology.noise.published import published_gaussian, published_subsets

Row = dict[str, Any]

# The recording that stands for each row of S Table 4. Its Vantage row agrees with nine cameras;
# the tenth was the failing one, which S 3.5 excludes.
TABLE_4 = {"T40": 10, "Bonita": 10, "Vantage": 9, "All": 30}
FIRST = ("tau_1_s", "adev_1_mm")
MINIMUM = ("adev_min_mm", "tau_min_s", "adev_min_lower_mm", "adev_min_upper_mm")
SUBSETS = "The recordings of the group as in the sheet."
GAUSSIAN = (
    "Moments of the cleaned coordinates, along x as in S and along the line between the markers "
    "(axis pair); only the latter's sigma_C can be held against sigma_L. chi2: test of L against "
    "N(mu_e, sigma_C) on every thinning_frames-th frame (empty: fewer than 20 independent ones; "
    "along the pair chi2_p is an upper bound). "
    "Drift and range are of one-second means (of tenths of a recording below 10 s)."
)
OUTLIERS = (
    "Samples taken for outliers. On clean Gaussian noise the filter itself takes the share in "
    "share_of_clean_gaussian_noise (0.34 % at 3 sigma and 241 frames) and leaves white_level_kept "
    "(0.966) of the white level: Allan deviations at short tau are 1.7 % low by that much. "
    "resolution: the smallest step the file can tell (int16 or float32 spacing, or a coarser "
    "rounding found in the values)."
)
ALLAN = (
    "Overlapping Allan deviation at one frame, at chosen averaging times, and at its minimum with "
    "the interval of the configured confidence."
)
TABLE_3_CAPTION = "Ids of the cameras of each subset; Vantage with 10 is deduced, not printed."
TABLE_4_CAPTION = (
    "Along x, in mm (sigma_12 in mm\u00b2). Vantage is the subset of nine, without the failing "
    "camera. The moments of a nine-hour twin scatter, as random walk dominates them; rho_12 is an "
    "outcome of the spectra of x1, x2 and L, except in row All: no coefficients were printed for "
    "all thirty cameras, and its twin is T40-10 scaled to this row, rho_12 included."
)
CHOSEN_TAUS_S = (0.1, 1.0, 10.0, 100.0, 1000.0)


def write(path: str | Path, rows: Sequence[Row], title: str, caption: str) -> None:
    """Write `<path>.csv` and `<path>.md` (`path` has no suffix); what a row lacks is empty."""
    head = dict.fromkeys(name for row in rows for name in row)
    whole = [{name: row.get(name) for name in head} for row in rows]
    write_with(path, whole, markdown(whole, title, caption))


def write_with(path: str | Path, rows: Sequence[Row], text: str, head: Sequence[str] = ()) -> None:
    """Write rows as `<path>.csv` and `text` as `<path>.md`; `head`: columns where no row is."""
    path = Path(path)
    table = path.with_name(f"{path.name}.csv")
    if rows:
        write_csv(table, rows)
    else:
        write_text(table, ",".join(head) + "\n")
    write_text(path.with_name(f"{path.name}.md"), text)


def aligned(lines: Sequence[Sequence[Any]]) -> list[str]:
    """Lines of a Markdown table, the first its head, columns of equal width."""
    cells = [[_shown(cell) for cell in line] for line in lines]
    width = [max(len(line[k]) for line in cells) for k in range(len(cells[0]))]
    shown = [_line(line, width) for line in cells]
    shown.insert(1, "|" + "|".join("-" * (w + 2) for w in width) + "|")
    return shown


def markdown(rows: Sequence[Row], title: str, caption: str) -> str:
    """A Markdown table, numbers to seven significant digits, columns of equal width."""
    head = list(rows[0])
    lines = aligned([head, *([row[name] for name in head] for row in rows)])
    return "\n".join([f"# {title}", "", caption, "", *lines, ""])


def _line(cells: Sequence[str], width: Sequence[int]) -> str:
    return "| " + " | ".join(c.ljust(w) for c, w in zip(cells, width, strict=True)) + " |"


def _shown(value: Any) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, (float, np.floating)):
        return f"{value:.7g}"
    return str(value).replace("|", "\\|").replace("\n", " ")


def source_sentence(sources: Mapping[str, str]) -> str:
    """What a caption says of where its recordings come from: name -> `twin` or `measured`."""
    twins = [name for name, source in sources.items() if source == "twin"]
    if not twins:
        return "All recordings are measured."
    if len(twins) == len(sources):
        return "All recordings are twins: simulated, from published or configured numbers."
    return f"Simulated (twins): {', '.join(twins)}; the others are measured."


def subsets(recordings: Sequence[Mapping[str, Any]]) -> list[Row]:
    """One row a recording: what the sheet says of it."""
    return [
        {
            "recording": row["recording"],
            "source": "twin" if row["twin"] else "measured",
            "camera_type": row["camera_type"],
            "n_cameras": row["n_cameras"],
            "camera_ids": ";".join(map(str, row["camera_ids"])),
            "comment": row["comment"],
        }
        for row in recordings
    ]


def allan_summary(
    recording: str, source: str, columns: Mapping[str, np.ndarray], expected: Sequence[str]
) -> list[Row]:
    """One row a series of allan.parquet: its first tau, chosen tau, and the minimum.

    The value at a chosen tau is that of the nearest tau computed, within 10 %, else empty; a series
    of `expected` without a single value has a row of empty cells.
    """
    rows = []
    overlapping = columns["estimator"] == "oadev"
    for series in expected:
        pick = overlapping & (columns["series"] == series)
        tau, adev = columns["tau_s"][pick], columns["adev_mm"][pick]
        lower, upper = columns["adev_lower_mm"][pick], columns["adev_upper_mm"][pick]
        row: Row = {"recording": recording, "source": source, "series": series}
        row |= {"tau_1_s": tau[0], "adev_1_mm": adev[0]} if tau.size else dict.fromkeys(FIRST)
        for wanted in CHOSEN_TAUS_S:
            k = int(np.abs(np.log(tau / wanted)).argmin()) if tau.size else -1
            near = k >= 0 and abs(tau[k] / wanted - 1) < 0.1
            row[f"adev_{wanted:g}s_mm"] = adev[k] if near else math.nan
        best = int(adev.argmin()) if tau.size else None
        least = [values[best] if tau.size else None for values in (adev, tau, lower, upper)]
        rows.append(row | dict(zip(MINIMUM, least, strict=True)))
    return rows


def standing_for(
    recordings: Mapping[str, Mapping[str, Any]], camera_type: str, n_cameras: int
) -> str | None:
    """Name of the recording of that subset: a measured one before a twin, then the first."""
    names = [
        name
        for name, row in recordings.items()
        if (row["camera_type"], row["n_cameras"]) == (camera_type, n_cameras)
    ]
    return min(names, key=lambda name: recordings[name]["twin"] is not None, default=None)


def source_of(recording: Mapping[str, Any] | None) -> str:
    """`twin`, `measured`, or `cited` where no recording stands for the published row."""
    return "cited" if recording is None else "twin" if recording["twin"] else "measured"


def skurowski_table_3(recordings: Mapping[str, Mapping[str, Any]]) -> list[Row]:
    """S Table 3: the cameras of every subset, as published and as in the sheet."""
    rows = []
    for (camera_type, n_cameras), ids in published_subsets().items():
        row = recordings.get(standing_for(recordings, camera_type, n_cameras))
        rows.append(
            {
                "camera_type": camera_type,
                "n_cameras": n_cameras,
                "published": ";".join(map(str, ids)),
                "regenerated": ";".join(map(str, row["camera_ids"])) if row else None,
                "source": source_of(row),
                "recording": row["recording"] if row else None,
            }
        )
    return rows


def skurowski_table_4(
    recordings: Mapping[str, Mapping[str, Any]], gaussian: Mapping[str, Mapping[str, float]]
) -> list[Row]:
    """S Table 4, long form: every number as published and as regenerated along x.

    gaussian: the row `axis = x` of gaussian.csv, by recording.
    """
    rows = []
    for camera_type, n_cameras in TABLE_4.items():
        name = standing_for(recordings, camera_type, n_cameras)
        found = gaussian.get(name, {}) if name else {}
        for quantity, published in published_gaussian(camera_type).items():
            rows.append(
                {
                    "camera_type": camera_type,
                    "quantity": quantity,
                    "published": published,
                    "regenerated": found.get(quantity),
                    "source": source_of(recordings.get(name)),
                    "recording": name,
                }
            )
    return rows
