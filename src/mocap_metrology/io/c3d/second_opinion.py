"""Comparison with ezc3d's reading of the same file, in a process of its own.

ezc3d hangs or dies on some damaged files and cannot be interrupted from within, so the process has
a time and a memory limit. It reads only files that passed our own check, and only where
it is known to count frames rightly.

The process runs this very file: a request in JSON on standard input, the answer in JSON as the last
line of standard output. So this file imports of the package what starts fast.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.header import FASTEST_HZ, SLOWEST_HZ

if TYPE_CHECKING:
    from mocap_metrology.io.c3d.structure import Structure

MOST_FRAMES = 65534  # from 65535 on ezc3d's count cannot be relied upon
TIME_LIMIT_S = 60.0
MEMORY_LIMIT = 4 << 30  # bytes of address space
RELATIVE_TOLERANCE = 5e-7  # float32 rounding of coordinate times scale, a few units of it


@dataclass(frozen=True)
class Request:
    """What was read from a file for `points` (places from 0); `position_mm` names a .npy file of
    (n_points, 3, n_frames). Limits in bytes and s."""

    path: str
    points: list[int]
    labels: list[str]
    n_points: int
    n_frames: int
    frame_bytes: int
    frame_rate_hz: float
    units: str
    mm_per_unit: float
    position_mm: str
    memory_limit: int
    time_limit_s: float


Answer = tuple[str, str]  # `agrees`, `differs` or `none`; the reason of the latter two


def ask_ezc3d(
    structure: Structure,
    points: Sequence[int],
    position_mm: npt.NDArray[np.floating],
    time_limit_s: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
) -> tuple[str, str]:
    """(opinion, remark) on what was read: `agrees`, `none` with the reason, `not asked (...)`.

    `position_mm` (n_points, 3, n_frames) as read here for `points`. Refuses where ezc3d reads the
    file and finds another number of frames, other labels, rate, unit, gaps or positions.
    """
    if structure.n_frames > MOST_FRAMES:
        return f"not asked ({structure.n_frames} frames > {MOST_FRAMES})", ""
    if structure.missing:
        lack = f"the file has no POINT:{structure.missing[0]}, which ezc3d needs"
        return f"not asked ({lack})", f"no second opinion: {lack}"
    if structure.processor == 86:
        return "not asked (ezc3d does not read MIPS files)", ""
    with tempfile.TemporaryDirectory() as folder:
        saved = Path(folder) / "position_mm.npy"
        np.save(saved, position_mm)
        request = Request(
            path=str(structure.path.resolve()),
            points=[int(p) for p in points],
            labels=list(structure.given_labels),
            n_points=structure.n_points,
            n_frames=structure.n_frames,
            frame_bytes=structure.frame_bytes,
            frame_rate_hz=structure.frame_rate_hz,
            units=structure.unit.written,
            mm_per_unit=structure.unit.mm,
            position_mm=str(saved),
            memory_limit=memory_limit,
            time_limit_s=time_limit_s,
        )
        opinion, reason = _run(request)
    if opinion == "differs":
        raise Refusal(
            f"{structure.name}: ezc3d reads it differently: {reason}; to read it without"
            " ezc3d, set second_opinion: false in the configuration"
        )
    return opinion, f"no second opinion: {reason}" if opinion == "none" else ""


def _run(request: Request) -> Answer:
    """The child's answer; whatever happens to the child is an answer too."""
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    try:
        child = subprocess.run(
            [sys.executable, "-P", __file__],  # -P: its folder does not shadow other modules
            input=json.dumps(asdict(request)),
            capture_output=True,
            text=True,
            timeout=request.time_limit_s,
            env={**os.environ, **threads},
            check=False,
        )
    except subprocess.TimeoutExpired:
        return "none", f"ezc3d took longer than {request.time_limit_s:g} s"
    except OSError as error:
        return "none", f"ezc3d could not be started: {error.strerror}"
    if child.returncode < 0:
        name = signal.Signals(-child.returncode).name
        return "none", f"ezc3d was ended by {name}"
    try:
        opinion, reason = json.loads(child.stdout.splitlines()[-1])
        return opinion, reason
    except (IndexError, TypeError, ValueError):
        lines = child.stderr.split("\n") if child.stderr.strip() else ["no answer"]
        last = next(line for line in reversed(lines) if line.strip())
        return "none", f"ezc3d failed: {last[:200]}"


# In the process


def main() -> None:
    """Answer one request."""
    request = Request(**json.load(sys.stdin))
    _limit(request.memory_limit, request.time_limit_s)
    try:
        what = _differences(request)
        answer = ("differs" if what else "agrees", what)
    except Exception as error:
        text = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        answer = "none", f"ezc3d does not read it ({text})"
    print()
    print(json.dumps(answer))


def _limit(memory: int, seconds: float) -> None:
    """Bound address space and processor time, where the system can."""
    try:
        import resource
    except ImportError:
        return
    for what, most in ((resource.RLIMIT_AS, memory), (resource.RLIMIT_CPU, int(seconds) + 1)):
        hard = resource.getrlimit(what)[1]
        most = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(what, (most, hard))


def _differences(request: Request) -> str:
    """What ezc3d reads differently, or an empty string."""
    import ezc3d

    file = ezc3d.c3d(request.path)
    parameters = file["parameters"]["POINT"]
    points = file["data"]["points"]
    if not points.shape[1]:  # it does not know names of parameters in small letters
        raise ValueError("it finds no points")
    if points.shape[1] != request.n_points:
        return f"{points.shape[1]} points instead of {request.n_points}"
    n = request.n_frames
    # Where ezc3d reads to the end of the file it counts the last block's padding as frames.
    spare = points[:3, :, n:]
    padding = spare.shape[2] * request.frame_bytes <= 512 and not np.nan_to_num(spare).any()
    if points.shape[2] < n or not padding:
        return f"{points.shape[2]} frames instead of {n}"
    for label, expected in zip(parameters["LABELS"]["value"], request.labels, strict=False):
        theirs = label.split("\0")[0].strip()
        if theirs.isascii() and expected.isascii() and theirs != expected.strip():
            return f"label {theirs!r} instead of {expected!r}"
    ours, rate = request.frame_rate_hz, float(file["header"]["points"]["frame_rate"])
    if ours and SLOWEST_HZ <= rate <= FASTEST_HZ and abs(rate - ours) > 1e-3 * ours:
        return f"{rate:g} Hz instead of {ours:g} Hz"
    units = [unit.strip("\0 ") for unit in parameters["UNITS"]["value"]]
    if units and units[0] and units[0] != request.units:
        return f"unit {units[0]!r} instead of {request.units!r}"
    return _compare_positions(points[:3, request.points, :n], request)


def _compare_positions(theirs: npt.NDArray[np.float64], request: Request) -> str:
    """Compare coordinates: theirs (3, n_points, n_frames) in file units, NaN at a gap they saw."""
    ours = np.load(request.position_mm, mmap_mode="r").transpose(1, 0, 2)
    theirs = theirs * request.mm_per_unit
    valid = np.isfinite(ours).all(axis=0)
    seen = np.isfinite(theirs).all(axis=0)
    # (0, 0, 0) is no measurement to us and a valid point to ezc3d.
    only_theirs = seen & (theirs != 0).any(axis=0) & ~valid
    only_ours = valid & ~seen
    for where, what in ((only_theirs, "valid"), (only_ours, "missing")):
        if where.any():
            point, frame = np.argwhere(where)[0]
            return f"point {request.points[point] + 1} is {what} in frame {frame + 1}"
    both = valid & seen
    off = np.abs(theirs - ours) > RELATIVE_TOLERANCE * np.abs(theirs)
    off = off.any(axis=0) & both
    if off.any():
        point, frame = np.argwhere(off)[0]
        pair = f"{theirs[:, point, frame].tolist()} instead of {ours[:, point, frame].tolist()} mm"
        return f"point {request.points[point] + 1}, frame {frame + 1}: {pair}"
    return ""


if __name__ == "__main__":
    main()
