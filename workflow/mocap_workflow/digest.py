"""A digest of what a script runs: itself, every module of the package it imports, the lock file.

Snakemake sees an edit of the script alone. Imports are found in the syntax tree, lazy, relative
and of scripts beside it too, and so are files of the package that the code names in a text (a
table it reads, a program it starts). Comments, docstrings and layout do not count, so editing
them repeats nothing; nor do imports under `if TYPE_CHECKING:`, which nothing runs.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from mocap_workflow.faults import Faults

TYPES_ONLY = ("TYPE_CHECKING", "typing.TYPE_CHECKING")


class Sources:
    """Scripts of one folder, one installed package, one lock file."""

    def __init__(self, scripts: Path, package: Path, lock: Path):
        self.scripts, self.package, self.lock = scripts, package, lock
        self.named: dict[str, list[Path]] = {}
        self.found: dict[str, list[Path]] = {}  # files of each name that is imported
        for path in sorted(package.rglob("*.*")):
            hidden = any(part.startswith((".", "__")) for part in path.relative_to(package).parts)
            if path.is_file() and not hidden:  # neither compiled code nor __init__.py
                self.named.setdefault(path.name, []).append(path)

    def digest(self, script: str) -> str:
        """Hexadecimal digest of a script of the folder, by its file name."""
        total = hashlib.sha256(_bare(self.lock).encode())
        for path in sorted(self.reached(self.scripts / script)):
            total.update(f"{path.name}\0{_read(path, self._base(path)).code}\0".encode())
        return total.hexdigest()[:16]

    def reached(self, script: Path) -> set[Path]:
        """The script and every file of the package and beside the script that it imports."""
        seen: set[Path] = set()
        waiting = [script]
        while waiting:
            path = waiting.pop()
            if path not in seen:
                seen.add(path)
                module = _read(path, self._base(path))
                for name in module.imports:
                    if name not in self.found:
                        self.found[name] = list(self._files(name))
                    waiting += self.found[name]
                for text in module.texts & self.named.keys():
                    waiting += self.named[text]
        return seen

    def _base(self, path: Path) -> str:
        """Dotted name of the package that relative imports of this file start from."""
        if self.package not in path.parents:
            return ""
        return ".".join((self.package.name, *path.parent.relative_to(self.package).parts))

    def _files(self, name: str) -> Iterator[Path]:
        """Files that importing a dotted name runs: the packages on the way, and the module."""
        first, *rest = name.split(".")
        if first != self.package.name:
            beside = self.scripts / f"{first}.py"
            if beside.is_file():
                yield beside
            return
        folder = self.package
        yield from _existing(folder / "__init__.py")
        for part in rest:
            yield from _existing(folder / f"{part}.py")
            folder = folder / part
            yield from _existing(folder / "__init__.py")


@dataclass(frozen=True)
class _Module:
    code: str
    imports: frozenset[str] = frozenset()
    texts: frozenset[str] = frozenset()


@cache
def _read(path: Path, base: str) -> _Module:
    if path.suffix != ".py":
        return _Module(hashlib.sha256(path.read_bytes()).hexdigest())
    tree = ast.parse(path.read_text(encoding="utf-8"))
    nodes = list(_run(tree))  # once, as it takes longest
    docstrings = _strip_docstrings(nodes)
    constants = (n for n in nodes if isinstance(n, ast.Constant) and id(n) not in docstrings)
    texts = frozenset(node.value for node in constants if isinstance(node.value, str))
    return _Module(ast.unparse(tree), frozenset(_imports(nodes, base)), texts)


def _run(tree: ast.Module) -> Iterator[ast.AST]:
    """Every node but those under `if TYPE_CHECKING:`."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        if isinstance(node, ast.If) and ast.unparse(node.test) in TYPES_ONLY:
            waiting += node.orelse
        else:
            waiting += ast.iter_child_nodes(node)


def _existing(path: Path) -> Iterator[Path]:
    if path.is_file():
        yield path


def _imports(nodes: Iterable[ast.AST], base: str) -> Iterator[str]:
    """Every dotted name that is imported; `from a import b` may mean the module a.b."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = base.split(".")[: len(base.split(".")) - node.level + 1] if node.level else []
            module = ".".join([*start, *([node.module] if node.module else [])])
            yield module
            yield from (f"{module}.{alias.name}" for alias in node.names)


def _strip_docstrings(nodes: Iterable[ast.AST]) -> set[int]:
    """Take the docstrings out of the tree of these nodes; return the ids of what they were."""
    holders = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
    stripped = set()
    for node in nodes:
        if isinstance(node, holders) and ast.get_docstring(node, clean=False) is not None:
            stripped.add(id(node.body[0].value))
            node.body = node.body[1:] or [ast.Pass()]
    return stripped


def _bare(lock: Path) -> str:
    """The lock file without comments and blank lines."""
    lines = (line.strip() for line in lock.read_text(encoding="utf-8").splitlines())
    return "\n".join(line for line in lines if line and not line.startswith("#"))


def installed(name: str, root: Path) -> Path:
    """Folder of the package that scripts will import, refused unless it is this checkout's.

    An environment of another checkout would otherwise run that one's code without a word.
    """
    spec = importlib.util.find_spec(name)
    expected = root / "src" / name
    if spec is None or spec.origin is None:
        raise Faults([f"{name} is not installed in this Python; expected the one of `make env`"])
    package = Path(spec.origin).resolve().parent
    if package != expected.resolve():
        wrong = f"{name} is imported from {package}; expected {expected}"
        raise Faults([f"{wrong}: run `make env` here and use its .venv"])
    return package
