"""Figures 8, 12, 13 and A1 of S: recordings compared by their Allan deviations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mocap_metrology.present.drawing.curves import Panel
from mocap_metrology.present.drawing.style import LOOKS, OTHER_LOOKS, styled
from mocap_metrology.present.families.adev import compared_figure, panels_figure
from mocap_metrology.present.families.members import curve_of
from mocap_metrology.present.families.subsets import subsets_figure
from mocap_metrology.present.skurowski.paper_noise import PAPER
from mocap_metrology.present.skurowski.subset_tables import TABLE_4, standing_for

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TITLES = {
    7: f"{PAPER}, Figure 7: a seismic crump",
    8: f"{PAPER}, Figure 8: Vantage with and without the failing camera",
    12: f"{PAPER}, Figure 12: Allan deviation by number of cameras",
    13: f"{PAPER}, Figure 13: Allan deviation by camera type",
    "A1": f"{PAPER}, Figure A1: z1 after the failing camera was replaced",
}
NOTE_A1 = "S's own: nine hours before the repair, a length it does not state after it."
TYPES = ("T40", "Bonita", "Vantage")
TYPE_LOOKS = dict(zip((*TYPES, "All"), (*LOOKS.values(), OTHER_LOOKS[0]), strict=True))
SERIES = ("x1", "x2", "L")
SERIES_A1 = "z1"
ALL_NOTE = (
    "No coefficients were published of all cameras: their twin is T40-10 with x1 and x2 made to "
    "meet Table 4, y and z as they are."
)
Rows = Mapping[str, Mapping[str, Any]]
Allan = Mapping[str, Mapping[str, np.ndarray]]  # columns of allan.parquet by recording


def subsets_of(rows: Rows) -> dict[str, dict[int, str]]:
    """Recordings of Figure 12 by camera type and number of cameras, without the failing camera."""
    return {
        kind: {
            n: standing_for(rows, kind, n)
            for n in sorted({r["n_cameras"] for r in rows.values() if r["camera_type"] == kind})
            if n <= TABLE_4[kind]
        }
        for kind in TYPES
    }


def numbers_figure(rows: Rows, allan: Allan, note: str) -> Figure:
    """S Figure 12: each camera type by number of cameras."""
    columns = {
        kind: {n: allan[name] for n, name in names.items()}
        for kind, names in subsets_of(rows).items()
    }
    return subsets_figure(columns, TITLES[12], f"Vantage without the failing camera. {note}")


def failing_figure(rows: Rows, allan: Allan, note: str, confidence: float) -> Figure | None:
    """S Figure 8: ten Vantage cameras, one of them failing, against nine; None without both."""
    names = {n: standing_for(rows, "Vantage", n) for n in (10, 9)}
    if None in names.values():
        return None
    shown = {
        f"{n} cameras, {how}": (allan[name], look)
        for (n, name), how, look in zip(
            names.items(), ("one failing", "without it"), (LOOKS["y"], LOOKS["x"]), strict=True
        )
    }
    return compared_figure(shown, SERIES, TITLES[8], note, confidence)


def types_figure(rows: Rows, allan: Allan, note: str, confidence: float) -> Figure:
    """S Figure 13: all sound cameras of each type, and of all types."""
    names = {kind: standing_for(rows, kind, n) for kind, n in TABLE_4.items()}
    shown = {
        f"{kind} ({TABLE_4[kind]})": (allan[name], TYPE_LOOKS[kind])
        for kind, name in names.items()
        if name is not None
    }
    text = f"{_remark(rows, names['All'])} {note}"
    return compared_figure(shown, SERIES, TITLES[13], text, confidence)


def _remark(rows: Rows, name: str | None) -> str:
    """What must be known of the recording of all cameras, if it is a twin."""
    return "" if name is None or rows[name]["twin"] is None else ALL_NOTE


@styled()
def repaired_figure(rows: Rows, others: Rows, allan: Allan, note: str, confidence: float) -> Figure:
    """S Figure A1: z1 of every camera type after the repair, and left of it of those that the
    sheet compares them with.

    rows: of the repaired recordings; others: of those named in their `compare_with`; allan: of all
    of them.
    """
    looks = {
        _label(row): TYPE_LOOKS.get(row["camera_type"], OTHER_LOOKS[1]) for row in rows.values()
    }
    after = {_label(row): name for name, row in rows.items()}
    before = {
        _label(row): row["compare_with"] for row in rows.values() if row["compare_with"] in others
    }
    panels = [
        Panel(title, [curve_of(allan[n], SERIES_A1, k, True) for k, n in names.items()], looks)
        for title, names in (("Before the repair", before), ("After the repair", after))
        if names
    ]
    remarks = [f"{name}: {row['comment']}." for name, row in rows.items() if row["comment"]]
    remarks.append(_remark(rows, standing_for(rows, "All", TABLE_4["All"])))
    text = f"{' '.join(remarks)} {note} {NOTE_A1}"
    return panels_figure(panels, TITLES["A1"], text, confidence)


def guess_a1(limits_s: Sequence[float]) -> str:
    """What repaired twins lack: Gauss-Markov terms below these T_c."""
    said = " or ".join(f"{limit:g} s" for limit in dict.fromkeys(limits_s))
    return (
        "S prints no coefficients after the repair, so what it takes from a twin is a guess: "
        f"correlated noise of T_c below {said}."
    )


def _label(row: Mapping[str, Any]) -> str:
    return f"{row['camera_type']} ({row['n_cameras']})"
