"""Shared fixtures. Reference recordings lie beside the project, in ../shared; without them the
tests that need them are skipped and say so."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def root() -> Path:
    """The project's root folder."""
    return ROOT


@pytest.fixture(scope="session")
def shared() -> Path:
    """Folder of recordings and reference data by other people."""
    folder = ROOT.parent / "shared"
    if not (folder / "data").is_dir():
        pytest.skip("reference data folder ../shared is absent")
    return folder


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files that run the whole workflow come first: what ends last is then short, and two workers
    end together."""
    items.sort(key=lambda item: "end_to_end" not in item.path.name)
