"""Bytes cut, changed, lost or doubled anywhere: a recording or a refusal in one line, no crash."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.extend(str(Path(__file__).parent / folder) for folder in ("text", "c3d"))
from make_c3d import build
from make_c3d import still as stored
from text_files import PLAIN, TAKE, n3d

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.read import read_recording

MARKERS = {".n3d": ("Marker_1", "Marker_2"), ".c3d": ("M1", "M2")}


def sound(folder: Path, name: str) -> bytes:
    if name in PLAIN:
        return PLAIN[name].encode()
    if name == "a.n3d":
        return n3d(TAKE, 100)
    if name == "i.c3d":
        whole = np.round(stored(20) / 0.1).astype(int)
        return build(folder / name, whole, processor="MIPS", scale=0.1).read_bytes()
    return build(folder / name, stored(20), trial=(1, 20), long_frames=20).read_bytes()


@pytest.mark.parametrize("name", [*PLAIN, "a.n3d", "i.c3d", "f.c3d"])
def test_damage_is_refused_in_one_line_or_harmless(tmp_path: Path, name: str) -> None:
    path, rng = tmp_path / name, np.random.default_rng(5)
    whole, refused = sound(tmp_path, name), 0
    for damage in range(200):
        spoilt = bytearray(whole)
        a, b = sorted(rng.integers(len(whole) if damage % 3 else 1100, size=2) % len(whole))
        if damage % 4 == 0:
            del spoilt[a:]
        elif damage % 4 == 1:
            spoilt[a], spoilt[b] = spoilt[a] ^ 1 << int(rng.integers(8)), int(rng.integers(256))
        elif damage % 4 == 2:
            del spoilt[a : a + 150]
        else:
            spoilt[b:b] = spoilt[a : a + 100]
        path.write_bytes(spoilt)
        try:
            found = read_recording([path], MARKERS.get(path.suffix, "AB"), None, False, damage > 99)
        except Refusal as refusal:
            refused += 1
            assert str(refusal).startswith(f"{name}: ") and "\n" not in str(refusal)
        else:
            assert found.position_mm.shape[:2] == (2, 3)
            assert found.position_mm.shape[2] <= 220
    assert refused > 90
