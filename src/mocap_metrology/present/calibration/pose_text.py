"""A calibration in words and numbers: verdict, pose with deviations, stations."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from mocap_metrology.lighthouse.assess.fit_checks import BOARD, EXPECTED_URAD
from mocap_metrology.present.calibration.calibration_files import CalibrationFiles
from mocap_metrology.present.tables import Record
from mocap_metrology.present.text.numbers import number

TIMES_SIGMA = 3.0
BEYOND_SIGMA = (
    "Error beyond 3 σ: σ is the scatter within this recording. It does not include errors that "
    "are constant during it (optics, lasers off the origin of the housing, scale of the board)."
)


def residual_limit(pose: Record) -> str:
    """`good below 577`, or where it is not good `usable below 2164`: limit of the residual in µrad;
    empty where none is known."""
    limit, good = _limit(pose, "residual")
    return "" if limit is None else f"{'good' if good else 'usable'} below {limit:.0f}"


def expected_urad(pose: Record) -> float:
    """Noise of one angle that the checks went by, in µrad."""
    limit, good = _limit(pose, "board poses")
    return EXPECTED_URAD if limit is None else limit / BOARD[0 if good else 1]


def _limit(pose: Record, name: str) -> tuple[float | None, bool]:
    """Limit of a check and whether it is that of the word good; None where it has none."""
    named = (check for check in pose.get("checks", ()) if check["name"] == name)
    check: Record = next(named, {})
    limit = check.get("limit")
    return (limit if isinstance(limit, int | float) else None), bool(check.get("ok"))


def beyond_sigma(entry: Record) -> bool:
    """Whether the error of an estimate against its reference is more than three standard deviations
    in a coordinate or about an axis."""
    if entry.get("covariance") is None or entry.get("errors_mm") is None:
        return False
    off = np.abs([*entry["errors_mm"], *entry["errors_deg"]])
    variance = np.diag(np.array(entry["covariance"], dtype=np.float64))
    return bool((off > TIMES_SIGMA * np.sqrt(np.clip(variance, 0, None))).any())


MM_DEG = slice(3), slice(3, 6)


def pose_rows(entry: Record) -> list[tuple[str, list[str]]]:
    """Rows of the pose: a label with its unit, and three numbers.

    The pose has as many decimals as its standard deviation, or its error against the reference
    where that is larger, has with two significant digits.
    """
    angles = [entry["rotation_deg"][k] for k in ("alpha", "beta", "gamma")]
    covariance = entry.get("covariance")
    sd = [np.nan] * 6
    if covariance is not None:
        variance = np.diag(np.array(covariance, dtype=np.float64))
        sd = np.sqrt(np.clip(variance, 0, None)).tolist()
    off = [*(entry.get("errors_mm") or [np.nan] * 3), *(entry.get("errors_deg") or [np.nan] * 3)]
    digits = [
        _decimals([*sd[own], *off[own]], usual) for own, usual in zip(MM_DEG, (1, 2), strict=True)
    ]
    rows = [("t, slave in master (mm)", _cells(entry["translation_mm"], digits[0], sign=True))]
    if covariance is not None:
        rows.append(("1 σ along x, y, z (mm)", _cells(sd[:3], _decimals(sd[:3], 1))))
    rows.append(("α, β, γ (°)", _cells(angles, digits[1], sign=True)))
    if covariance is not None:
        rows.append(("1 σ about x, y, z (°)", _cells(sd[3:], _decimals(sd[3:], 2))))
    if entry.get("errors_mm"):
        rows.append(("t − reference (mm)", _cells(off[:3], _decimals(off[:3], 1), sign=True)))
        rows.append(("rotation from it (°)", _cells(off[3:], _decimals(off[3:], 2), sign=True)))
    return rows


def _decimals(values: Sequence[float], usual: int) -> int:
    """Decimals that give the largest two significant digits, three at most; the usual number where
    none is known."""
    known = [abs(float(value)) for value in values if np.isfinite(value) and value]
    return int(np.clip(1 - np.floor(np.log10(max(known))), 0, 3)) if known else usual


def _cells(values: Iterable[float], digits: int, sign: bool = False) -> list[str]:
    return [number(float(value), digits, sign) for value in values]


def facts(given: CalibrationFiles, board_m: np.ndarray | None) -> list[str]:
    """Lines beside the numbers: the data behind the pose, distances to where the board was on the
    whole, and the stations."""
    entry, lines = given.chosen, []
    if entry is not None:
        baseline = np.linalg.norm(entry["translation_mm"]) / 1e3
        lines.append(f"{entry['estimator']}, stage {entry['stage']}, {entry['optics']} optics")
        lines.append(f"baseline {number(float(baseline), 3)} m")
        if (residual := entry.get("residual_rms_urad")) is not None:
            limit = residual_limit(given.pose)
            lines.append(
                f"residual {residual:.0f} µrad of {number(entry['n_angles'])} angles"
                + (f" ({limit})" if limit else "")
            )
        if (share := entry.get("mirrored_share")) is not None:
            lines.append(f"mirrored board poses {100 * share:.2g} %")
    if board_m is not None:
        far = f"board {number(float(np.linalg.norm(board_m)), 2)} m from the master"
        if entry is not None:
            slave = board_m - np.array(entry["translation_mm"]) / 1e3
            far += f", {number(float(np.linalg.norm(slave)), 2)} m from the slave"
        lines.append(far)
    return lines + [_station(station) for station in given.stations]


def _station(station: Record) -> str:
    """One station in a line: id, mode, where its factory values come from."""
    known = "id unknown" if station.get("id") is None else f"id {station['id']}"
    if station.get("factory") is None:
        factory = f"no factory values: {station.get('why') or 'none found'}"
    elif station.get("frames_found"):
        n = station["frames_found"]
        factory = f"factory values from {n} frame{'' if n == 1 else 's'}"
    else:
        factory = "factory values from a file"
    return f"{station['role']}: {known}, mode {station.get('mode') or 'unknown'}, {factory}"
