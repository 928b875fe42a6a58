"""The cache of compiled kernels follows edits of called helpers in other files."""

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from mocap_metrology.common import compiled

HELPER = "from toy.common.compiled import njit\n\n@njit\ndef inner(x):\n    return x * {factor}\n"
ENTRY = """from toy.common.compiled import njit
from toy.helper import inner

@njit
def outer(x):
    return inner(x) + 1.0
"""


def copy_of_decorator(folder: Path) -> Path:
    package = folder / "toy"
    (package / "common").mkdir(parents=True)
    for init in (package, package / "common"):
        (init / "__init__.py").write_text("")
    source = Path(compiled.__file__).read_text()
    (package / "common/compiled.py").write_text(source.replace("mocap_metrology", "toy"))
    (package / "entry.py").write_text(ENTRY)
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
    (package / "helper.py").write_text(HELPER.format(factor=2.0))
    assert result(tmp_path) == "21.0"
    assert list(package.glob(".compiled/*/*/*.nbi"))  # it was kept
    # of another length: Python's own byte code tells sources by size and whole seconds alone
    (package / "helper.py").write_text(HELPER.format(factor=3.25))
    assert result(tmp_path) == "33.5"


def kernels(tree: ast.Module) -> Iterator[ast.FunctionDef]:
    """Compiled functions of a module."""
    functions = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
    return (f for f in functions if any("njit" in ast.unparse(one) for one in f.decorator_list))


def test_edit_of_a_called_helper_is_seen_where_no_cache_can_be_kept(tmp_path):
    package = copy_of_decorator(tmp_path)
    (package / ".compiled").touch()  # files where the folders would be
    (tmp_path / "mocap-metrology").touch()
    for factor, expected in ((2.0, "21.0"), (3.25, "33.5")):
        (package / "helper.py").write_text(HELPER.format(factor=factor))
        assert result(tmp_path, XDG_CACHE_HOME=str(tmp_path)) == expected
    assert not list(tmp_path.rglob("*.nbi"))


@pytest.mark.parametrize("fault", ["", "writable", "link"])
def test_code_of_others_is_not_run(tmp_path, fault):
    """Who may write to a cache of numba may run code as whoever loads it. Where the package has
    none of its own, it is in the user's folder of caches, and nowhere under a shared one."""
    package = copy_of_decorator(tmp_path)
    (package / "helper.py").write_text(HELPER.format(factor=2.0))
    (package / ".compiled").touch()
    caches = tmp_path / "caches/mocap-metrology"
    if fault == "link":
        (tmp_path / "theirs").mkdir()
        caches.parent.mkdir()
        caches.symlink_to(tmp_path / "theirs")
    elif fault:
        caches.mkdir(parents=True)
        caches.chmod(0o777)
    environment = {"XDG_CACHE_HOME": str(caches.parent), "TMPDIR": str(tmp_path)}
    assert result(tmp_path, **environment) == "21.0"
    stored = list(tmp_path.rglob("*.nbi"))
    assert bool(stored) == (not fault)
    assert all(caches in path.parents for path in stored)
    if stored:
        assert {path.stat().st_mode & 0o777 for path in (caches, *caches.glob("*"))} == {0o700}


def test_a_kernel_cannot_choose_a_cache_of_its_own():
    with pytest.raises(TypeError, match="cache"):
        compiled.njit(cache=True)
    with pytest.raises(TypeError, match="cache"):
        compiled.njit(lambda x: x, cache=False)


def test_what_a_kernel_imports_comes_from_a_file_that_the_hash_covers():
    """A constant of another file would stay as it was in the machine code."""
    texts = {path: path.read_text() for path in compiled.PACKAGE.rglob("*.py")}
    trees = {path: ast.parse(text) for path, text in texts.items() if "@njit" in text}
    for path, tree in trees.items():
        imported = {
            alias.asname or alias.name: node.module
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom)
            if (node.module or "").startswith("mocap_metrology")
            for alias in node.names
        }
        for kernel in kernels(tree):
            body = [x for part in kernel.body for x in ast.walk(part)]  # annotations do not run
            names = [x for x in body if isinstance(x, ast.Name)]
            local = {x.id for x in names if isinstance(x.ctx, ast.Store)}
            local |= {x.arg for x in ast.walk(kernel) if isinstance(x, ast.arg)}
            for name in {x.id for x in names} & imported.keys() - local - {"njit"}:
                source = compiled.PACKAGE.parent / (imported[name].replace(".", "/") + ".py")
                assert source in trees, f"{path}: {kernel.name}: {name}"


def test_every_compiled_function_goes_through_the_decorator():
    """No module but `compiled` imports numba, and all import the decorator in the way that the
    hash looks for, so no kernel escapes the cache's rule."""
    for path in compiled.PACKAGE.rglob("*.py"):
        if path.name != "compiled.py":
            text = path.read_text()
            lines = text.splitlines()
            assert not [x for x in lines if x.startswith(("import numba", "from numba"))], path
            assert ("@njit" in text) == ("common.compiled import njit" in text), path
