"""Where a recording comes from, in the words of a figure's note."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mocap_metrology.common.words import three

MOST_NAMED = 2  # files
UNITS = (("mm", 1.0), ("µm", 1e3), ("nm", 1e6))


def source_words(origin: Mapping[str, Any]) -> str:
    """`twin T40-10: simulated`; `measured, take.c3d`; of many segments the first and their number.

    origin: what a table of the recording says of itself.
    """
    if origin["twin"]:
        return f"twin {origin['twin']}: simulated"
    files = [part["path"].rpartition("/")[2] for part in origin.get("segments") or ()]
    files = list(dict.fromkeys(files))
    if len(files) > MOST_NAMED:
        return f"measured, {files[0]} and {len(files) - 1} more files"
    return ", ".join(["measured", " and ".join(files)] if files else ["measured"])


def step_words(resolution_mm: float, kind: str) -> str:
    """`step 61 nm (float32)`: of the stored values, in a unit that needs no power of ten."""
    if not resolution_mm > 0:
        return "step unknown"
    unit, per_mm = next((u, f) for u, f in UNITS if resolution_mm * f >= 0.1 or u == "nm")
    return f"step {three(float(f'{resolution_mm * per_mm:.2g}'))} {unit} ({kind})"
