"""What ezc3d reads from the same file, asked in a process of its own.

ezc3d hangs or dies on some damaged files and cannot be interrupted from within, so the process has
a time and a memory limit. It is asked only about files that passed our own check, and only where
it is known to count frames rightly.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.structure import Structure

MOST_FRAMES = 65534  # from 65535 on ezc3d's count cannot be relied upon
TIME_LIMIT_S = 60.0
MEMORY_LIMIT = 4 << 30  # bytes of address space
CHILD = Path(__file__).with_name("ezc3d_child.py")


def ask_ezc3d(
    structure: Structure,
    points: Sequence[int],
    position_mm: np.ndarray,
    time_limit_s: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
) -> tuple[str, str]:
    """(opinion, remark) on what was read: `agrees`, `none` with the reason, `not asked (...)`.

    `position_mm` (n_points, 3, n_frames) as read here for `points`. Refuses where ezc3d reads the
    file and finds another number of frames, other labels, rate, unit, gaps or positions.
    """
    if structure.n_frames > MOST_FRAMES:
        return f"not asked ({structure.n_frames} frames > {MOST_FRAMES})", ""
    if structure.processor == 86:
        return "not asked (ezc3d does not read MIPS files)", ""
    request = {
        "path": str(structure.path.resolve()),
        "points": [int(p) for p in points],
        "labels": list(structure.given_labels),
        "n_points": structure.n_points,
        "n_frames": structure.n_frames,
        "frame_bytes": structure.frame_bytes,
        "frame_rate_hz": structure.frame_rate_hz,
        "units": structure.units,
        "mm_per_unit": structure.mm_per_unit,
        "memory_limit": memory_limit,
        "time_limit_s": time_limit_s,
    }
    with tempfile.TemporaryDirectory() as folder:
        request["position_mm"] = str(Path(folder) / "position_mm.npy")
        np.save(request["position_mm"], position_mm)
        answer = _run(request, time_limit_s)
    if answer["opinion"] == "differs":
        raise Refusal(f"{structure.name}: ezc3d reads it differently: {answer['reason']}")
    remark = f"no second opinion: {answer['reason']}" if answer["opinion"] == "none" else ""
    return answer["opinion"], remark


def _run(request: dict, time_limit_s: float) -> dict[str, str]:
    """The child's answer; whatever happens to the child is an answer too."""
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    try:
        child = subprocess.run(
            [sys.executable, "-P", str(CHILD)],  # -P: its folder does not shadow other modules
            input=json.dumps(request),
            capture_output=True,
            text=True,
            timeout=time_limit_s,
            env={**os.environ, **threads},
            check=False,
        )
    except subprocess.TimeoutExpired:
        return {"opinion": "none", "reason": f"ezc3d took longer than {time_limit_s:g} s"}
    except OSError as error:
        return {"opinion": "none", "reason": f"ezc3d could not be started: {error.strerror}"}
    if child.returncode < 0:
        name = signal.Signals(-child.returncode).name
        return {"opinion": "none", "reason": f"ezc3d was ended by {name}"}
    try:
        return json.loads(child.stdout.splitlines()[-1])
    except (IndexError, ValueError):
        lines = child.stderr.split("\n") if child.stderr.strip() else ["no answer"]
        last = next(line for line in reversed(lines) if line.strip())
        return {"opinion": "none", "reason": f"ezc3d failed: {last[:200]}"}
