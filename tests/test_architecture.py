"""Imports of the package only point down, and it knows nothing of the workflow."""

import ast
import subprocess
import sys
import tomllib
import zipfile
from collections import defaultdict
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "src/mocap_metrology"
MODULES = sorted(PACKAGE.rglob("*.py"))
NUMBERS = {"common", "settings", "noise", "accuracy", "lighthouse"}
BELOW = {  # what each part may import of the others
    "common": set(),
    "settings": {"common"},
    "io": {"common"},
    "noise": {"common", "settings"},
    "accuracy": {"common", "settings", "noise"},
    "lighthouse": {"common", "settings"},
    "papers": NUMBERS,
    "present": NUMBERS | {"papers"},
    "recording": NUMBERS | {"io", "present"},
    "calibration": NUMBERS | {"io", "present"},
    "face": NUMBERS | {"io", "recording"},
    "cli": NUMBERS | {"io", "present", "recording", "calibration"},
}


def imports(path: Path) -> Iterator[str]:
    """Every module named in an import, lazy and relative ones included."""
    base = ["mocap_metrology", *path.parent.relative_to(PACKAGE).parts]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = base[: len(base) - node.level + 1] if node.level else []
            module = ".".join([*start, *([node.module] if node.module else [])])
            yield from (f"{module}.{alias.name}" for alias in node.names)


def part_of(path: Path) -> str:
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


def test_imports_point_down() -> None:
    for path in MODULES:
        part = part_of(path)
        assert part in BELOW or path.parent == PACKAGE, path
        for name in imports(path):
            first, *rest = name.split(".")
            assert first not in ("snakemake", "mocap_workflow", "step"), f"{path} imports {name}"
            assert first != "yaml" or path.name == "documents.py", f"{path} imports {name}"
            assert first != "ezc3d" or part == "io", f"{path} imports {name}; only io may"
            if first == "mocap_metrology" and rest and part in BELOW:
                assert rest[0] in BELOW[part] | {part}, f"{path} imports {name}"


def test_a_wheel_has_every_file_and_names_every_library_it_imports(tmp_path: Path) -> None:
    """As `pip install` of it needs; OpenCV is an extra, and `snakemake` is no part of it."""
    root = PACKAGE.parents[1]
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run([*build, "--wheel-dir", tmp_path, root], check=True)
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as packed:
        held = {name for name in packed.namelist() if name.startswith("mocap_metrology/")}
    here = {path for path in PACKAGE.rglob("*") if path.is_file() and path.suffix != ".pyc"}
    files = {str(path.relative_to(PACKAGE.parent)) for path in here}
    assert {name for name in files if ".compiled" not in name} <= held
    stated = tomllib.loads((root / "pyproject.toml").read_text())["project"]["dependencies"]
    modules = {"yaml", "cv2", "markdown_it", *stated}
    modules |= {
        "PIL",
        "mpl_toolkits",
        "annotated_types",
        "pydantic_core",
    }  # of matplotlib and pydantic
    used = {name.partition(".")[0] for path in MODULES for name in imports(path)}
    assert used <= modules | sys.stdlib_module_names | {"mocap_metrology"}


def arrows() -> dict[tuple[str, ...], dict[str, set[str]]]:
    """Within each folder of the package, at every depth: what each module or folder imports of
    those beside it."""
    found: dict[tuple[str, ...], dict[str, set[str]]] = defaultdict(lambda: defaultdict(set))
    for path in MODULES:
        module = path.relative_to(PACKAGE).with_suffix("").parts
        for name in imports(path):
            first, *parts = name.split(".")
            if first != "mocap_metrology":
                continue
            place = PACKAGE.joinpath(*parts)
            other = parts if place.is_dir() or place.with_suffix(".py").is_file() else parts[:-1]
            same = [a == b for a, b in zip(module, other, strict=False)]
            depth = same.index(False) if False in same else len(same)
            if depth < min(len(module), len(other)):
                found[module[:depth]][module[depth]].add(other[depth])
    return found


def test_no_circles_at_any_depth() -> None:
    """Neither folders nor modules beside each other import each other, directly or by others."""
    folders = arrows()
    assert {"noise", "present"} <= folders[()].keys()
    assert "fit" in folders[("noise",)]["assess"]
    for beside in folders.values():
        TopologicalSorter(beside).prepare()  # CycleError names the circle
    with pytest.raises(CycleError):
        TopologicalSorter({"a": {"b"}, "b": {"c"}, "c": {"a"}}).prepare()


def test_the_environment_is_not_read_as_configuration() -> None:
    """Choices are arguments; only the compiler's cache asks who and where it is."""
    for path in MODULES:
        text = path.read_text(encoding="utf-8")
        assert "os.environ[" not in text and "getenv(" not in text, path
