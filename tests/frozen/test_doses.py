"""Stored results over doses of single disturbances (`test_frozen` has whole recordings)."""

import json
from pathlib import Path

import pytest

from . import doses, estimates, fits, functions, light, words
from .digest import changed
from .test_frozen import stored

MADE = doses.CASES | estimates.CASES | fits.CASES | functions.CASES | light.CASES | words.CASES


@pytest.mark.parametrize("name", MADE)
def test_results_of_all_doses_are_as_stored(name: str, tmp_path: Path) -> None:
    assert changed(MADE[name](folder=tmp_path), json.loads(stored(name).read_text())) == []
