"""No number of any result changes unnoticed. Not whether they are right, which the other tests ask,
but that they are what they were: `python -m tests.frozen` stores them anew and says what changed.
"""

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from sample_files import HOW, samples_folder

from . import calibrations, groups, recordings
from .digest import Flat, changed

STORED = Path(__file__).parent / "stored"
MADE: dict[str, Callable[[Path], Flat]] = {
    **{kind: partial(recordings.recording, kind) for kind in recordings.KINDS},
    **{name: lambda folder, f=f: f(folder=folder) for name, f in calibrations.CASES.items()},
    **groups.CASES,
}


def stored(name: str) -> Path:
    return STORED / f"{name.replace(' ', '-')}.json"


def of_samples(name: str) -> Flat | None:
    """Of real recordings, where they are there."""
    samples = samples_folder()
    read, *given = groups.REAL[name]
    return read(samples, *given) if samples else None


@pytest.mark.parametrize("name", MADE)
def test_results_are_as_stored(name: str, tmp_path: Path) -> None:
    assert changed(MADE[name](tmp_path), json.loads(stored(name).read_text())) == []


@pytest.mark.parametrize("name", groups.REAL)
def test_readings_of_real_files_are_as_stored(name: str) -> None:
    found = of_samples(name)
    if found is None:
        pytest.skip(f"the sample recordings are missing: {HOW}")
    assert changed(found, json.loads(stored(name).read_text())) == []
