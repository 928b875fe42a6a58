"""The cache of compiled kernels follows edits of called helpers in other files."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from mocap_metrology.common import compiled

HELPER = (
    "from {name}.common.compiled import njit\n\n@njit\ndef inner(x):\n    return x * {factor}\n"
)
ENTRY = """from {name}.common.compiled import njit
from {name}.helper import inner

@njit
def outer(x):
    return inner(x) + 1.0
"""


def copy_of_decorator(folder: Path, name: str = "toy") -> Path:
    package = folder / name
    (package / "common").mkdir(parents=True)
    for init in (package, package / "common"):
        (init / "__init__.py").write_text("")
    source = Path(compiled.__file__).read_text()
    (package / "common/compiled.py").write_text(source.replace("mocap_metrology", name))
    (package / "entry.py").write_text(ENTRY.format(name=name))
    return package


def result(folder: Path, **environment: str) -> str:
    code = "from toy.entry import outer; print(outer(10.0))"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(folder)} | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def test_edit_of_a_called_helper_is_seen(tmp_path):
    package = copy_of_decorator(tmp_path)
    (package / "helper.py").write_text(HELPER.format(name="toy", factor=2.0))
    assert result(tmp_path) == "21.0"
    assert list(package.glob(".compiled/*/*/*.nbi"))  # it was kept
    # of another length: Python's own byte code tells sources by size and whole seconds alone
    (package / "helper.py").write_text(HELPER.format(name="toy", factor=3.25))
    assert result(tmp_path) == "33.5"


def test_every_compiled_function_goes_through_the_decorator():
    """No module but `compiled` imports numba, and all import the decorator in the way that the
    hash looks for, so no kernel escapes the cache's rule."""
    for path in compiled.PACKAGE.rglob("*.py"):
        if path.name != "compiled.py":
            text = path.read_text()
            lines = text.splitlines()
            assert not [x for x in lines if x.startswith(("import numba", "from numba"))], path
            assert ("@njit" in text) == ("common.compiled import njit" in text), path
