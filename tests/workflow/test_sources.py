"""The hash of a script's sources changes with any file that it imports, and with no other."""

import shutil
from pathlib import Path

import pytest
from mocap_workflow import sources
from mocap_workflow.sources import Sources, installed

from mocap_metrology.common.faults import Faults

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "src/mocap_metrology"

FILES = {
    "scripts/clean.py": "from step import step\nfrom package.io.read import (\n    one,\n)\n",
    "scripts/draw.py": "def f():\n    from package.present.pages import site\n",
    "scripts/step.py": "import package.common.errors\n",
    "package/__init__.py": "from package import present\n",
    "package/io/__init__.py": "",
    "package/io/read.py": "from package.common import faults\n",
    "package/common/errors.py": "",
    "package/common/faults.py": "",
    "package/noise/search.py": "",
    "package/present/pages/site.py": "",
    "package/present/pages/__pycache__/site.pyc": "",
    "package/present/html/page.html": "",
    "package/present/pages/texts.toml": "",
    "package/reference/table.csv": "",
    "lock.txt": "",
}


def hashes(root: Path) -> list[str]:
    """Of a script that reads, and of one that draws."""
    for cached in (sources.content, sources.data_in, sources.imported, sources.files_of):
        cached.cache_clear()
    source = Sources(root / "scripts", root / "package", root / "lock.txt")
    return [source("clean.py")(None), source("draw.py")(None)]


@pytest.fixture
def small(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / "a" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "a" / name).write_text(text)
    return tmp_path / "a"


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("scripts/clean.py", [True, False]),
        ("scripts/step.py", [True, False]),
        ("scripts/draw.py", [False, True]),
        ("package/__init__.py", [False, False]),
        ("package/io/__init__.py", [True, False]),
        ("package/io/read.py", [True, False]),
        ("package/common/errors.py", [True, False]),
        ("package/common/faults.py", [True, False]),
        ("package/noise/search.py", [False, False]),
        ("package/present/pages/site.py", [False, True]),
        ("package/present/pages/__pycache__/site.pyc", [False, False]),
        ("package/present/html/page.html", [False, True]),
        ("package/present/pages/texts.toml", [False, True]),
        ("package/reference/table.csv", [True, True]),
        ("lock.txt", [True, True]),
    ],
)
def test_what_an_edit_changes(small: Path, name: str, changed: list[bool]) -> None:
    before = hashes(small)
    assert hashes(Path(shutil.copytree(small, small.with_name("b")))) == before
    with (small / name).open("a") as stream:
        stream.write("# edited\n")
    assert [old != new for old, new in zip(before, hashes(small), strict=True)] == changed


def test_the_package_is_that_of_the_workflow(tmp_path: Path, monkeypatch) -> None:
    """The environment of another checkout serves as long as nothing differs."""
    assert installed("mocap_metrology", ROOT) == PACKAGE.resolve()
    with pytest.raises(Faults, match="not_there is not installed in this Python"):
        installed("not_there", ROOT)
    assert installed("mocap_metrology", tmp_path) == PACKAGE.resolve()
    monkeypatch.setattr(sources, "VERSION", "9.9")
    with pytest.raises(Faults, match=r"mocap_metrology 0\.1\.0 is installed; expected 9\.9"):
        installed("mocap_metrology", tmp_path)
    copy = tmp_path / "src/mocap_metrology"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__", ".*"))
    assert installed("mocap_metrology", tmp_path) == PACKAGE.resolve()
    (copy / "noise/columns.py").write_text("# a word\n")
    with pytest.raises(Faults, match=r"mocap_metrology is imported from .*; expected .*make env"):
        installed("mocap_metrology", tmp_path)


def test_the_workflow_and_its_package_have_one_version() -> None:
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert f'version = "{sources.VERSION}"' in text
