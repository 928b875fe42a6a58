"""Boards of photodiodes, and other places from CSV files."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from mocap_metrology.common import spreadsheet
from mocap_metrology.common.errors import Refusal

COLUMNS = ("x_m", "y_m", "z_m")
NORMALS = ("nx", "ny", "nz")
LARGEST_M = 2.0  # a board is carried by hand: beyond this it is in mm
FEWEST_DIODES = 4  # a calibration needs; tracking needs three
PLACE_COLUMNS = ("label", "x_m", "y_m", "z_m")


def csv_rows(path: str | Path, columns: Sequence[str]) -> list[list[str]]:
    """Cells of a CSV file without its header, which begins with these columns."""
    name, expected = Path(path).name, ",".join(columns)
    try:
        rows = spreadsheet.rows(Path(path).read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        raise Refusal(f"{name}: cannot be read ({error}); expected a CSV {expected}") from None
    header = [cell.strip() for cell in rows[0]] if rows else []
    if header[: len(columns)] != list(columns):
        raise Refusal(f"{name}: header is {','.join(header)!r}; expected {expected}")
    spreadsheet.check_width(rows, name)
    return rows[1:]


def read_places(
    path: str | Path, thing: str, largest_m: float, origin: str
) -> dict[str, np.ndarray]:
    """Label -> position (3,) in m, in file order, from a CSV with the columns label, x_m, y_m, z_m;
    thing: what has a label, origin: of the frame, in words; largest_m: of a coordinate, beyond
    which a file is in mm. Raises `Refusal` for a file that is no such thing."""
    name = Path(path).name
    rows = csv_rows(path, PLACE_COLUMNS)
    places: dict[str, np.ndarray] = {}
    for number, row in enumerate(rows, start=2):
        if not row:
            continue
        label = row[0].strip()
        position = np.full(3, np.nan)
        with suppress(ValueError):
            position[0], position[1], position[2] = map(spreadsheet.number, row[1:4])
        if not (label and label.isprintable() and np.isfinite(position).all()):
            raise Refusal(f"{name}: line {number} is {','.join(row)!r}; expected label,x_m,y_m,z_m")
        if label in places:
            raise Refusal(f"{name}: label {label} occurs twice; expected one line per {thing}")
        if np.abs(position).max() > largest_m:
            raise Refusal(
                f"{name}: {thing} {label} is {np.abs(position).max():g} m from {origin};"
                f" expected metres, below {largest_m:g} m (is the file in mm?)"
            )
        places[label] = position
    if len(places) < 3:
        raise Refusal(f"{name}: {len(places)} {thing}s; a pose needs at least three")
    return places


def narrowness_m(places: np.ndarray) -> float:
    """How far places (n, 3) spread off the line nearest to them: root of the sum of squares, m."""
    return float(np.linalg.svd(places - places.mean(axis=0), compute_uv=False)[1])


def flat_board(
    columns: int = 8, rows: int = 4, width_m: float = 0.24, height_m: float = 0.16
) -> np.ndarray:
    """The default board of twins: a flat grid that faces along +x, centred, (n, 3) in metres; y
    runs to the left, z up. Diodes count along rows, from the lower left as a station sees it."""
    y = np.linspace(-width_m / 2, width_m / 2, columns)
    z = np.linspace(-height_m / 2, height_m / 2, rows)
    grid = np.stack(np.meshgrid(y, z), axis=-1).reshape(-1, 2)
    return np.column_stack([np.zeros(len(grid)), grid])


def read_board(path: str | Path) -> np.ndarray:
    """Positions of the diodes in metres, (n, 3), from a CSV with columns x_m, y_m, z_m. Raises
    `Refusal` for missing columns, cells that are no numbers, and a board in mm."""
    name = Path(path).name
    return check_board(_numbers(csv_rows(path, COLUMNS), 0, f"{name}: line"), name)


def read_normals(path: str | Path) -> np.ndarray | None:
    """Unit vectors in which the diodes look, (n, 3), from the columns nx, ny, nz of a file that
    `read_board` accepts; None where it has none. Raises `Refusal` for what is no direction."""
    try:
        rows = csv_rows(path, COLUMNS + NORMALS)
    except Refusal:
        return None
    name = Path(path).name
    normals = _numbers(rows, len(COLUMNS), f"{name}: line")
    length = np.linalg.norm(normals, axis=1)
    if odd := np.flatnonzero(~(np.abs(length - 1) < 0.01)).tolist():
        said = f"{name}: nx,ny,nz of diode {odd[0]} have the length {length[odd[0]]:g}"
        raise Refusal(f"{said}; expected unit vectors, or no such columns")
    return normals / length[:, None]


def _numbers(rows: list[list[str]], first: int, where: str) -> np.ndarray:
    points = []
    for number, row in enumerate(rows, start=2):
        if not row:
            continue
        try:
            x, y, z = (spreadsheet.number(cell) for cell in row[first : first + 3])
        except ValueError:
            said = f"{where} {number} is {','.join(row)[:80]!r}"
            raise Refusal(f"{said}; expected numbers, positions in metres") from None
        points.append([x, y, z])
    return np.array(points)


def digest(board: np.ndarray) -> str:
    """A hash of the positions of the diodes to 1 um, by which recordings of one board are
    recognised."""
    return hashlib.sha256(np.rint(1e6 * board).astype("<i8").tobytes()).hexdigest()[:16]


def check_board(board: np.ndarray, name: str) -> np.ndarray:
    """Refuse a board that is no board: too few diodes, two at one place, or in mm."""
    if board.ndim != 2 or board.shape[1] != 3 or not np.isfinite(board).all():
        raise Refusal(f"{name}: expected three finite numbers per diode: x_m,y_m,z_m")
    if len(board) < FEWEST_DIODES:
        raise Refusal(f"{name}: {len(board)} diodes; a calibration needs at least {FEWEST_DIODES}")
    extent = float(np.ptp(board, axis=0).max())
    if extent > LARGEST_M:
        raise Refusal(
            f"{name}: the diodes span {extent:g} m; expected metres, below {LARGEST_M:g} m"
            " (is the file in mm?)"
        )
    apart = np.linalg.norm(board[:, None] - board[None], axis=-1) + 10 * np.eye(len(board))
    if apart.min() < 1e-4:
        i, j = np.argwhere(apart == apart.min())[0]
        raise Refusal(
            f"{name}: diodes {i} and {j} have the same position; expected different positions"
        )
    if narrowness_m(board) < 1e-3:
        raise Refusal(f"{name}: all diodes are on one line; expected a surface")
    return board


def check_count(board: np.ndarray, n_diodes: int, highest_seen: int, where: str) -> None:
    """Refuse a board with another number of diodes than the recording has."""
    if len(board) > n_diodes or highest_seen >= len(board):
        raise Refusal(
            f"{where}: the recording shows light on diode {highest_seen} of {n_diodes} (from 0),"
            f" the board has {len(board)} diodes; expected a board in diode order"
        )
