"""Arrows between the parts of the package only point down, and it knows nothing of the workflow."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "src/mocap_metrology"
MODULES = sorted(PACKAGE.rglob("*.py"))
# What each part may import of the others.
BELOW = {
    "common": set(),
    "io": {"common"},
    "noise": {"common"},
    "lighthouse": {"common"},
    "papers": {"common", "noise", "lighthouse"},
    "present": {"common", "noise", "lighthouse", "papers"},
    "pipeline": {"common", "io", "noise", "lighthouse", "present"},
    "cli": {"common", "io", "noise", "present", "pipeline"},
}


def part(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0]


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


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_point_down(path: Path) -> None:
    own = part(path)
    for name in imports(path):
        first, *rest = name.split(".")
        assert first not in ("snakemake", "mocap_workflow", "step"), f"{path} imports {name}"
        # Configuration is read elsewhere; this one reads a format that is YAML.
        assert first != "yaml" or path.name == "factory_file.py", f"{path} imports {name}"
        assert first != "ezc3d" or own == "io", f"{path} imports {name}; only io may"
        if first == "mocap_metrology" and rest and own in BELOW:
            assert rest[0] in BELOW[own] | {own}, f"{path} imports {name}"


def imported_modules(path: Path) -> Iterator[tuple[str, ...]]:
    """The modules of the package that one of its files imports, as parts of their path."""
    for name in imports(path):
        first, *parts = name.split(".")
        if first == "mocap_metrology":
            place = PACKAGE.joinpath(*parts)
            is_module = place.is_dir() or place.with_suffix(".py").is_file()
            yield tuple(parts if is_module else parts[:-1])


def arrows() -> dict[tuple[str, ...], dict[str, set[str]]]:
    """Within each folder of the package, at every depth: what each module or folder imports of
    those beside it."""
    found: dict[tuple[str, ...], dict[str, set[str]]] = defaultdict(lambda: defaultdict(set))
    for path in MODULES:
        own = path.relative_to(PACKAGE).with_suffix("").parts
        for other in imported_modules(path):
            same = [a == b for a, b in zip(own, other, strict=False)]
            depth = same.index(False) if False in same else len(same)
            if depth < min(len(own), len(other)):
                found[own[:depth]][own[depth]].add(other[depth])
    return found


ARROWS = arrows()


@pytest.mark.parametrize("folder", sorted(ARROWS), ids=lambda folder: ".".join(folder) or "all")
def test_no_circles_at_any_depth(folder: tuple[str, ...]) -> None:
    """Neither folders nor modules beside each other import each other, directly or by others."""
    TopologicalSorter(ARROWS[folder]).prepare()  # CycleError names the circle


def test_a_circle_is_found() -> None:
    with pytest.raises(CycleError):
        TopologicalSorter({"a": {"b"}, "b": {"c"}, "c": {"a"}}).prepare()
    assert {"noise", "present"} <= ARROWS[()].keys()
    assert "fit" in ARROWS[("noise",)]["assess"]


def test_every_part_has_its_place() -> None:
    folders = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").is_file()}
    assert folders <= set(BELOW)


def test_the_environment_is_not_read_as_configuration() -> None:
    """Choices are arguments; only the compiler's cache asks who and where it is."""
    for path in MODULES:
        text = path.read_text(encoding="utf-8")
        assert "os.environ[" not in text and "getenv(" not in text, path
