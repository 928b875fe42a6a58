"""Real recordings that several files of tests read, each read once."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from mocap_metrology.lighthouse.decode.libsurvive import read_libsurvive
from mocap_metrology.lighthouse.decode.turns import Light


@pytest.fixture(scope="session")
def light_of(samples: Path) -> Callable[[str, str], Light]:
    """Light of second-generation stations on an object, by file and name."""

    @cache
    def light(file: str, name: str) -> Light:
        found, _ = read_libsurvive(samples / f"lighthouse2/{file}.rec.gz", name)
        assert isinstance(found, Light)
        return found

    return light
