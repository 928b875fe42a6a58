"""NDI First Principles: 3D data exported as text (TSV, CSV, or text under the suffix .xls).

Layout as in exports of Optotrak recordings and in two public readers of them
(otaithleigh/optotrak; load_opto of UW-Madison): `Number of frames: 500`, `Frequency: 50`,
`Units: mm`, an empty line; `Frame` and three names a marker (`A x`, `A y`, `A z`); rows that end
with a delimiter. A marker that was not seen has empty cells, or -3.697314E28 as in N3D files.
"""

from __future__ import annotations

import re
from itertools import islice
from pathlib import Path

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.n3d import MISSING_BELOW
from mocap_metrology.io.text.columns import find_columns
from mocap_metrology.io.text.layout import Layout, check_text, count, lines, named, rate
from mocap_metrology.io.units import read_unit

WHAT = "an NDI First Principles export"
START = "Number of frames:"
FIELD = re.compile(r'"?([^:\t,;]+):\s*([^\t;"]*?)[\s,;"]*')


def layout(path: Path) -> Layout:
    """Read the header of an export; refuses what is none or contradicts itself."""
    check_text(path, WHAT)
    fields: dict[str, str] = {}
    above: list[int] = []
    every_line = lines(path)
    for line in islice(every_line, 20):
        if line.text.startswith("Frame") and line.text[5:6] in ("\t", ",", ";"):
            break
        if told := FIELD.fullmatch(line.text):
            fields.setdefault(told[1].strip(), told[2])
        elif line.text.lstrip(' "')[:1].isdigit():
            above.append(line.number)
    else:
        raise Refusal(f"{path.name}: is not {WHAT}: it has no line Frame, A x, A y, A z ...")
    if above:
        raise Refusal(f"{path.name}: line {above[0]} has numbers above the line Frame, A x ...")
    delimiter = line.text[5]
    names = line.cells(delimiter)
    while not names[-1]:
        names.pop()
    where = f"{path.name}: line {line.number}"
    columns = find_columns(names, where)
    if columns is None:
        raise Refusal(f"{where} has no columns x, y, z of a marker")
    first = next((row for row in every_line if row.text.strip(f"{delimiter} ")), None)
    if first is None:
        raise Refusal(f"{path.name}: has no frames: nothing follows the header")
    n_frames = fields.get("Number of frames", "")
    return Layout(
        path=path,
        encoding="First Principles text",
        labels=named(columns.labels),
        columns=columns.positions,
        frame_rate_hz=rate(fields.get("Frequency", ""), path.name),
        unit=read_unit([fields.get("Units", "")], "Units", path.name),
        delimiter=delimiter,
        first=first,
        n_columns=len(names),
        frame_column=columns.frame,
        declared=("Number of frames", count(n_frames, "Number of frames", path.name)),
        missing_below=MISSING_BELOW,
    )
