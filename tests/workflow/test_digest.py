"""The digest of a script follows what it runs, and nothing else."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path

import pytest
from mocap_workflow import digest as module
from mocap_workflow.digest import Sources, installed
from mocap_workflow.faults import Faults

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
    "numbers_of_mine/kinds.py": "class Kind: ...",
    "numbers_of_mine/instead.py": "Kind = object",
    "numbers_of_mine/common.py": """
        from typing import TYPE_CHECKING
        if TYPE_CHECKING:
            from numbers_of_mine.kinds import Kind
        else:
            from numbers_of_mine.instead import Kind

        def kernel() -> Kind:
            '''Why.'''
            return 1  # one
    """,
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
    left_out = {"scripts/other.py", "lock.txt"}
    left_out |= {f"numbers_of_mine/{name}.py" for name in ("unused", "kinds")}
    assert found == set(FILES) - left_out


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("scripts/clean.py", "def run", "# a word\ndef run"),
        ("scripts/clean.py", "Clean.", "Clean it."),
        ("numbers_of_mine/common.py", "# one", "# two"),
        ("numbers_of_mine/common.py", "Why.", "Because."),
        ("numbers_of_mine/common.py", "'''Why.'''\n", "'''Why.'''\n\n\n"),
        ("numbers_of_mine/kinds.py", "...", "x: int"),
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
        ("numbers_of_mine/instead.py", "object", "int", False),
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
    shutil.copytree(root, copy, ignore=shutil.ignore_patterns("__pycache__"))
    assert digests(copy) == digests(root)


def test_the_package_of_another_checkout_is_refused(tmp_path: Path) -> None:
    root = Path(__file__).resolve().parents[2]
    package = installed("mocap_metrology", root)
    assert package == (root / "src/mocap_metrology").resolve()
    with pytest.raises(Faults, match=r"mocap_metrology is imported from .*; expected .*make env"):
        installed("mocap_metrology", tmp_path)
    with pytest.raises(Faults, match="not_there is not installed in this Python"):
        installed("not_there", root)


SCRIPTS = Path(__file__).resolve().parents[2] / "workflow/scripts"


@pytest.mark.parametrize("script", sorted(SCRIPTS.glob("*.py")), ids=lambda path: path.stem)
def test_what_a_script_imports_is_there(script: Path) -> None:
    """A module that was moved away would leave the digest without a word, and fail in the job."""
    for node in ast.walk(ast.parse(script.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("mocap_metrology"):
            for alias in node.names:
                if not hasattr(importlib.import_module(node.module), alias.name):
                    importlib.import_module(f"{node.module}.{alias.name}")


def test_a_result_depends_on_no_more_than_makes_it() -> None:
    """Else editing the ant colony would repeat Allan deviations, and the reader of C3D files twins
    of nine hours."""
    root = SCRIPTS.parents[1]
    sources = Sources(SCRIPTS, root / "src/mocap_metrology", root / "requirements/requirements.txt")

    def reached(script: str) -> set[str]:
        package = sources.package
        paths = (path for path in sources.reached(SCRIPTS / script) if package in path.parents)
        return {path.relative_to(package).as_posix() for path in paths}

    allan = reached("allan.py")
    assert "noise/confidence.py" in allan
    assert not {path for path in allan if "_fit/" in path or "estimat" in path}
    made = {path for path in reached("simulate.py") if path.startswith("c3d/")}
    assert made == {"c3d/__init__.py", "c3d/write.py", "c3d/numbers.py"}
