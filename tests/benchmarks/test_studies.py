"""Every study can be begun after a change of what it measures."""

import importlib
import pkgutil

import pytest

import benchmarks

NAMES = [one.name for one in pkgutil.walk_packages(benchmarks.__path__, "benchmarks.")]


@pytest.mark.parametrize("name", [one for one in NAMES if not one.endswith("__main__")])
def test_finds_what_it_imports(name: str) -> None:
    importlib.import_module(name)
