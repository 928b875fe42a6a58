"""Figures of the two papers that are not regenerated, and why."""

from __future__ import annotations

from mocap_metrology.present.tables import Row
from mocap_metrology.present.text.captions import PAPERS

CAPTION = "All other figures and all tables of both papers are regenerated, from twins or theory."
COLUMNS = ("paper", "figure", "shows", "reason")
S, J = PAPERS["skurowski"], PAPERS["jansen"]
LEFT_OUT = (
    (S, "Figure 4", "camera locations: a view in Vicon Blade and a photograph of the laboratory",
     "a photograph, and places of cameras of which the paper prints no coordinates"),
    (S, "Figure 5", "drawing of the calibration wand (T-frame)",
     "a drawing of a vendor's part, without data"),
    (J, "Fig. 1", "a person with receivers on the limbs, and the pose found",
     "a photograph of an earlier experiment (reference 19 there); its recording was not published"),
    (J, "Fig. 2", "illustration of a Lighthouse seen from the front",
     "an illustration of the device, without data"),
    (J, "Fig. 4", "the calibration board with its 32 photodiodes",
     "a photograph; the diodes' places are in the board file of each calibration"),
    (J, "Fig. 9", "two Lighthouses with markers for motion capture",
     "a photograph; the twins' marker mounts are in their mount files"),
)  # fmt: skip


def left_out() -> list[Row]:
    """One row a figure."""
    return [dict(zip(COLUMNS, line, strict=True)) for line in LEFT_OUT]
