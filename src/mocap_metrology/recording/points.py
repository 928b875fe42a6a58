"""Reference points of a group: a row a point, beside what a better system measured there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from mocap_metrology.accuracy.points import Points, check
from mocap_metrology.accuracy.points_report import point_rows, points_document
from mocap_metrology.common import spreadsheet
from mocap_metrology.common.documents import text_of
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import write_json
from mocap_metrology.io.read import bodies_of, orientation_of
from mocap_metrology.present import tables
from mocap_metrology.present.accuracy.points import points_figure, sentences
from mocap_metrology.present.plot.figure import Texts, save
from mocap_metrology.present.text import captions
from mocap_metrology.recording.results import Table

COLUMNS = ("point", "x_mm", "y_mm", "z_mm")
UNSTEADY, LEAST_UNSTEADY_MM = 10.0, 1.0  # scatter of the frames of a take against the median, in mm


@dataclass(frozen=True)
class RecordedPoint:
    """A point as it was recorded: mean place (3,) in mm, standard deviation of a frame, mean
    attitude (3, 3), the identity of a marker."""

    place: np.ndarray
    noise_mm: float
    turn: np.ndarray


def first_marker(clean: str | Path, paths: Sequence[str], row: Mapping[str, Any]) -> RecordedPoint:
    """The first marker, or body, of a recording at rest; row: columns as `clean.Entry` has them."""
    table = Table.read(clean)
    label = table.origin["labels"][0]
    place = np.array([values for _, values in table.in_mm()][:3])
    turn = np.eye(3)
    names = row["column_names"]
    if label in bodies_of(paths[0], None, names):
        told = table.origin["frame_rate_hz"], row["accept_truncated"], names
        quaternion = orientation_of(paths, label, *told)
        known = np.isfinite(quaternion).all(axis=0)
        turn = Rotation.from_quat(quaternion[:, known].T).mean().as_matrix()
    return RecordedPoint(np.nanmean(place, axis=1), float(np.nanstd(place, axis=1).max()), turn)


def read_reference(path: str | Path) -> dict[str, tuple[np.ndarray, float]]:
    """Place (3,) and standard uncertainty (0 without a column u_mm) of each point of a CSV file."""
    name, columns = Path(path).name, f"{', '.join(COLUMNS)}[, u_mm]"
    text = text_of(path, f"a CSV {columns}")
    try:
        rows = spreadsheet.rows(text)
    except ValueError as error:
        raise Refusal(f"{name}: {error}; expected a CSV {columns}") from None
    header = [cell.strip() for cell in rows[0]] if rows else []
    if any(header.count(column) != 1 for column in COLUMNS) or header.count("u_mm") > 1:
        raise Refusal(f"{name}: columns {', '.join(header) or 'nothing'}; expected {columns}")
    spreadsheet.check_width(rows, name)
    places: dict[str, tuple[np.ndarray, float]] = {}
    for line, cells in enumerate(rows[1:], start=2):
        if not cells:
            continue
        row = {key: cell.strip() for key, cell in zip(header, cells, strict=False)}
        try:
            place = np.array([spreadsheet.number(row[axis]) for axis in COLUMNS[1:]])
            u = spreadsheet.number(row.get("u_mm") or "0")
            is_named = row["point"] and row["point"].isprintable()
            if not (is_named and np.isfinite(place).all() and 0 <= u < np.inf):
                raise ValueError
        except (KeyError, ValueError):
            said = ",".join(cells)[:80]
            raise Refusal(f"{name}, line {line}: {said}; expected numbers of mm") from None
        if row["point"] in places:
            raise Refusal(f"{name}: point {row['point']} stands twice; expected each once")
        places[row["point"]] = place, u
    return places


def write_points(
    group: str,
    rows: Sequence[Mapping[str, Any]],
    recorded: Sequence[RecordedPoint],
    reference: str | Path,
    path: Path,
    figure: Path,
) -> None:
    """Tables beside the JSON file `path`, and the figure; rows: `recording`, `point`, `source` in
    the order in which they were taken."""
    known = read_reference(reference)
    missing = [row["point"] for row in rows if row["point"] not in known]
    if missing:
        what = f"{Path(reference).name}: has no point {', '.join(missing)}"
        raise Refusal(f"{what}; it has {', '.join(known)}")
    points = Points(
        np.array([one.place for one in recorded]),
        np.array([one.turn for one in recorded]),
        np.array([known[row["point"]][0] for row in rows]),
    )
    check(points, group)
    labels = [str(row["point"]) for row in rows]
    of_takes = np.array([one.noise_mm for one in recorded])
    of_reference = np.array([known[label][1] for label in labels])
    # One take that moves must not make all of them noisy
    noise_mm = float(np.median(np.hypot(of_takes, of_reference)))
    document, off = points_document(points, noise_mm, labels)
    least = max(UNSTEADY * float(np.median(of_takes)), LEAST_UNSTEADY_MM)
    document |= {
        "has_u": bool(of_reference.any()),
        "unsteady": [label for label, mm in zip(labels, of_takes, strict=True) if mm > least],
        "unsteady_mm": float(of_takes.max()),
    }
    document |= {"sentences": sentences(document)}
    named = [{key: row[key] for key in ("point", "recording", "source")} for row in rows]
    table = [one | more for one, more in zip(named, point_rows(points, off), strict=True)]
    source = tables.source_sentence({row["recording"]: row["source"] for row in rows})
    said = " ".join((captions.POINTS, *document["sentences"], source))
    write_json(path, {"group": group, **document})
    tables.write(path.with_suffix(".csv"), table, f"{group}: reference points", said)
    texts = Texts(f"{group}: {len(labels)} reference points", source)
    save(points_figure(points, off, labels, document["cuts"], texts), figure)
