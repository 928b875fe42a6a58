"""Where a recording comes from and how fine its file is, in words."""

from __future__ import annotations

import pytest

from mocap_metrology.present.recording.recording_figures import source_words, step_words


def test_a_measured_recording_names_its_files() -> None:
    parts = [{"path": f"data/take{k}.c3d"} for k in (1, 2, 3)]
    said = [source_words({"twin": None, "segments": parts[:k]}) for k in range(4)]
    assert said == [
        "measured",
        "measured, take1.c3d",
        "measured, take1.c3d and take2.c3d",
        "measured, take1.c3d and 2 more files",
    ]
    assert source_words({"twin": None}) == "measured"
    assert source_words({"twin": "T40-10", "segments": parts}) == "simulated stand-in (twin) T40-10"


@pytest.mark.parametrize(
    ("step_mm", "text"),
    [
        (2.0**-14, "step 61 nm (k)"),  # of a float32 near 1 m, in mm
        (0.01, "step 10 µm (k)"),
        (0.1, "step 0.1 mm (k)"),
        (3.1e-4, "step 0.31 µm (k)"),
        (5e-9, "step 0.005 nm (k)"),
        (1e-13, "step below 0.001 nm (k)"),
        (float("nan"), "step unknown"),
        (0.0, "step unknown"),
    ],
)
def test_steps(step_mm, text) -> None:
    assert step_words(step_mm, "k") == text
