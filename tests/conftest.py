"""Shared fixtures. Without the recordings by other people (`make samples`) the tests that read them
are skipped."""

from pathlib import Path
from typing import Any

import hypothesis
import pytest
from sample_files import HOW, samples_folder

ROOT = Path(__file__).resolve().parents[1]
# The same examples in every run; busy machines need no limit of time an example.
hypothesis.settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
hypothesis.settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def root() -> Path:
    """The project's root folder."""
    return ROOT


@pytest.fixture(scope="session")
def samples() -> Path:
    """Folder of recordings by other people."""
    folder = samples_folder()
    if folder is None:
        pytest.skip(f"needs recordings by other people: {HOW}")
    return folder


@pytest.fixture(scope="session")
def headset(samples: Path) -> dict[str, Any]:
    """A real recording at rest by libsurvive: the headset and the controller, decoded."""
    from mocap_metrology.lighthouse.decode.chain import decode

    path = samples / "lighthouse/libsurvive_extras/lh1_test_cal.rec.gz"
    return {name: decode(path, "libsurvive-rec", name) for name in ("HMD", "T20")}


@pytest.fixture(scope="session")
def reference() -> Path:
    """Folder of published tables, as transcribed from the papers."""
    return ROOT / "tests/reference"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest files come first, then folders with long ones: what ends last is then short, and
    two workers end together."""
    longest = ("test_laboratory.py", "test_frozen.py", "test_doses.py")
    folders = ("workflow", "steps", "lighthouse", "noise")

    def place(item: pytest.Item) -> tuple[bool, int]:
        own = [k for k, name in enumerate(folders) if name in item.path.parts]
        return item.path.name not in longest, own[0] if own else len(folders)

    items.sort(key=place)
