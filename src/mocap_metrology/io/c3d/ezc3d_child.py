"""Run as a process by `second_opinion`: read a file with ezc3d, compare, answer in JSON.

The request is JSON on standard input, the answer the last line of standard output. It knows
nothing of this package, so that it starts fast.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np

RELATIVE_TOLERANCE = 5e-7  # float32 rounding of coordinate times scale, a few units of it


def limit(memory: int, seconds: float) -> None:
    """Bound address space and processor time, where the system can."""
    try:
        import resource
    except ImportError:
        return
    for what, most in ((resource.RLIMIT_AS, memory), (resource.RLIMIT_CPU, int(seconds) + 1)):
        hard = resource.getrlimit(what)[1]
        most = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(what, (most, hard))


def differences(request: dict[str, Any]) -> str:
    """What ezc3d reads differently, or an empty string."""
    import ezc3d

    file = ezc3d.c3d(request["path"])
    parameters = file["parameters"]["POINT"]
    found = file["data"]["points"]
    if found.shape[1] != request["n_points"]:
        return f"{found.shape[1]} points instead of {request['n_points']}"
    n = request["n_frames"]
    # Where ezc3d reads to the end of the file it takes the last block's padding for frames.
    spare = found[:3, :, n:]
    padding = spare.shape[2] * request["frame_bytes"] <= 512 and not np.nan_to_num(spare).any()
    if found.shape[2] < n or not padding:
        return f"{found.shape[2]} frames instead of {n}"
    for theirs, ours in zip(parameters["LABELS"]["value"], request["labels"], strict=False):
        theirs = theirs.split("\0")[0].strip()
        if theirs.isascii() and ours.isascii() and theirs != ours.strip():
            return f"label {theirs!r} instead of {ours!r}"
    ours, rate = request["frame_rate_hz"], float(file["header"]["points"]["frame_rate"])
    if ours and rate and abs(rate - ours) > 1e-3 * ours:
        return f"{rate:g} Hz instead of {ours:g} Hz"
    units = [unit.strip("\0 ") for unit in parameters["UNITS"]["value"]]
    if units and units[0] and units[0] != request["units"]:
        return f"unit {units[0]!r} instead of {request['units']!r}"
    return positions(found[:3, request["points"], :n], request)


def positions(theirs: np.ndarray, request: dict[str, Any]) -> str:
    """Compare coordinates: theirs (3, n_points, n_frames) in file units, NaN at a gap they saw."""
    ours = np.load(request["position_mm"], mmap_mode="r").transpose(1, 0, 2)
    theirs = theirs * request["mm_per_unit"]
    valid = np.isfinite(ours).all(axis=0)
    seen = np.isfinite(theirs).all(axis=0)
    # (0, 0, 0) is no measurement to us and a valid point to ezc3d.
    only_theirs = seen & (theirs != 0).any(axis=0) & ~valid
    only_ours = valid & ~seen
    for where, what in ((only_theirs, "valid"), (only_ours, "missing")):
        if where.any():
            point, frame = np.argwhere(where)[0]
            return f"point {request['points'][point] + 1} is {what} in frame {frame + 1}"
    both = valid & seen
    off = np.abs(theirs - ours) > RELATIVE_TOLERANCE * np.abs(theirs)
    off = off.any(axis=0) & both
    if off.any():
        point, frame = np.argwhere(off)[0]
        pair = f"{theirs[:, point, frame].tolist()} instead of {ours[:, point, frame].tolist()} mm"
        return f"point {request['points'][point] + 1}, frame {frame + 1}: {pair}"
    return ""


def main() -> None:
    """Answer one request."""
    request = json.load(sys.stdin)
    limit(request["memory_limit"], request["time_limit_s"])
    try:
        what = differences(request)
        answer = {"opinion": "differs" if what else "agrees", "reason": what}
    except Exception as error:
        text = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        answer = {"opinion": "none", "reason": f"ezc3d does not read it ({text})"}
    print()
    print(json.dumps(answer))


if __name__ == "__main__":
    main()
