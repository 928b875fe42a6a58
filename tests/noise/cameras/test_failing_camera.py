"""What docs/cameras.md says of how surely a noisy camera is named, in fewer twins."""

from __future__ import annotations

import pytest

TWINS, SPREAD = 20, 0.10
APART = "one at a time, frames not shared"


def study(*values: str):
    return pytest.param(*values, marks=pytest.mark.study)


@pytest.mark.parametrize(
    ("subsets", "duration"),
    [
        ("each left out once", "10 min"),
        study("each left out once", "9 h"),
        study("one at a time", "10 min"),
        study("one at a time", "9 h"),
        study("as S: 2 3 4 5 6 8 10", "10 min"),
        study("as S: 2 3 4 5 6 8 10", "9 h"),
        study(APART, "10 min"),
        study(APART, "9 h"),
    ],
)
def test_a_camera_twice_as_noisy_is_named_and_no_sound_one(
    root, monkeypatch, subsets: str, duration: str
) -> None:
    """Of 100 takes it is named in 97 or more (where frames are not shared, the greatest rise is at
    its addition in 92), and of a sound take anything is said in one at most. Of 20 draws so, fewer
    than 16 (14) are right, or more than 2 wrong, in one of a thousand."""
    monkeypatch.syspath_prepend(str(root / "benchmarks"))
    import failing_camera

    right, least = ("raised", 70) if subsets == APART else ("found", 80)
    for line in failing_camera.run(subsets, TWINS, 1, duration, SPREAD):
        found = dict(zip(failing_camera.HEAD, line, strict=True))
        assert float(found[right]) >= least, found
        assert float(found["blamed"]) <= 10, found
        assert float(found["false rise"]) <= 10, found
