"""The digest of a script follows what it runs, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest
from lib import digest as module
from lib.digest import Sources, installed
from lib.faults import Faults

FILES = {
    "scripts/clean.py": """
        '''Clean.'''
        from beside import step

        def run():
            from numbers_of_mine.noise import hampel
            import numbers_of_mine.late
    """,
    "scripts/beside.py": "step = 1",
    "scripts/other.py": "import beside",
    "numbers_of_mine/__init__.py": "",
    "numbers_of_mine/late.py": "import os",
    "numbers_of_mine/unused.py": "x = 1",
    "numbers_of_mine/common.py": "def kernel():\n    '''Why.'''\n    return 1  # one",
    "numbers_of_mine/noise/__init__.py": "",
    "numbers_of_mine/noise/hampel.py": "from ..common import kernel\nfrom . import table",
    "numbers_of_mine/noise/table.py": "NAME = 'table.csv'\nCHILD = 'child.py'",
    "numbers_of_mine/reference/table.csv": "a,b",
    "numbers_of_mine/noise/child.py": "print(1)",
    "lock.txt": "numpy==2  # the newest\n",
}


@pytest.fixture
def root(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        lines = text.splitlines()
        path.write_text("\n".join(line.removeprefix(" " * 8) for line in lines) + "\n")
    return tmp_path


def digests(root: Path) -> tuple[str, str]:
    module._read.cache_clear()
    sources = Sources(root / "scripts", root / "numbers_of_mine", root / "lock.txt")
    return sources.digest("clean.py"), sources.digest("other.py")


def test_what_is_reached(root: Path) -> None:
    sources = Sources(root / "scripts", root / "numbers_of_mine", root / "lock.txt")
    reached = sources.reached(root / "scripts/clean.py")
    found = {path.relative_to(root).as_posix() for path in reached}
    left_out = {"scripts/other.py", "numbers_of_mine/unused.py", "lock.txt"}
    assert found == set(FILES) - left_out


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("scripts/clean.py", "def run", "# a word\ndef run"),
        ("scripts/clean.py", "Clean.", "Clean it."),
        ("numbers_of_mine/common.py", "# one", "# two"),
        ("numbers_of_mine/common.py", "Why.", "Because."),
        ("numbers_of_mine/common.py", "'''Why.'''\n", "'''Why.'''\n\n\n"),
        ("numbers_of_mine/unused.py", "1", "2"),
        ("lock.txt", "numpy", "# a word\nnumpy"),
    ],
)
def test_words_and_unrelated_modules_change_nothing(
    root: Path, name: str, old: str, new: str
) -> None:
    before = digests(root)
    path = root / name
    path.write_text(path.read_text().replace(old, new))
    assert digests(root) == before


@pytest.mark.parametrize(
    ("name", "old", "new", "both"),
    [
        ("scripts/clean.py", "late", "unused", False),
        ("scripts/beside.py", "1", "2", True),
        ("numbers_of_mine/common.py", "return 1", "return 2", False),
        ("numbers_of_mine/late.py", "os", "sys", False),
        ("numbers_of_mine/reference/table.csv", "a", "c", False),
        ("numbers_of_mine/noise/child.py", "1", "2", False),
        ("lock.txt", "==2", "==3", True),
    ],
)
def test_an_edit_changes_the_digest_of_those_who_run_it(
    root: Path, name: str, old: str, new: str, both: bool
) -> None:
    before = digests(root)
    path = root / name
    path.write_text(path.read_text().replace(old, new))
    changed = [one != other for one, other in zip(before, digests(root), strict=True)]
    assert changed == [True, both]


def test_a_copy_elsewhere_has_the_same_digest(root: Path, tmp_path_factory) -> None:
    import shutil

    copy = tmp_path_factory.mktemp("copy") / "clone"
    shutil.copytree(root, copy)
    assert digests(copy) == digests(root)


def test_the_package_of_another_checkout_is_refused(tmp_path: Path) -> None:
    root = Path(__file__).resolve().parents[2]
    package = installed("mocap_metrology", root)
    assert package == (root / "src/mocap_metrology").resolve()
    with pytest.raises(Faults, match=r"mocap_metrology is imported from .*; expected .*make env"):
        installed("mocap_metrology", tmp_path)
    with pytest.raises(Faults, match="not_there is not installed in this Python"):
        installed("not_there", root)
