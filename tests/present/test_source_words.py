"""Where a recording comes from and how fine its file is, in words."""

from __future__ import annotations

import math

import pytest

from mocap_metrology.present.recording.recording_figures import source_words, step_words

FILES = [{"path": f"data/take{k}.c3d"} for k in (1, 2, 3)]


@pytest.mark.parametrize(
    ("twin", "files", "words"),
    [
        (None, FILES[:0], "measured"),
        (None, FILES[:2], "measured, take1.c3d and take2.c3d"),
        (None, FILES, "measured, take1.c3d and 2 more files"),
        ("T40-10", FILES, "simulated stand-in (twin) T40-10"),
    ],
)
def test_sources(twin, files, words) -> None:
    assert source_words({"twin": twin, "segments": files}) == words


STEPS = {2.0**-14: " 61 nm (k)", 0.1: " 0.1 mm (k)", 5e-9: " 0.005 nm (k)"}  # first: float32 at 1 m


@pytest.mark.parametrize(
    ("step_mm", "words"), [*STEPS.items(), (1e-13, " below 0.001 nm (k)"), (math.nan, " unknown")]
)
def test_steps(step_mm: float, words: str) -> None:
    assert step_words(step_mm, "k") == f"step{words}"
