"""Which tests reach a line: the statements that each test runs, from one marked run, and the names
of constants and compiled functions, in which no mark stands, in the statements that use them.

Marks are stores into one array, set before each statement while the package is imported: far
quicker than a trace. What a fixture or a cached function ran counts for every test that uses it.
"""

import ast
import builtins
import functools
import signal
import time
from collections import defaultdict
from collections.abc import Callable, Iterable
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any

import pytest

PACKAGE = "mocap_metrology"


class Units:
    """Statements in functions, and blind units, in which no mark can stand: statements outside of
    functions, and compiled functions. With the names that each uses."""

    def __init__(self, package: Path) -> None:
        self.places: dict[str, list[tuple[int, int, str]]] = {}
        self.marks: dict[tuple[str, int, int], int] = {}  # of statements, by module and position
        self.marked: list[str] = []
        self.users: dict[tuple[str, str], set[str]] = defaultdict(set)  # of (module, name)
        self.names: dict[str, list[str]] = {}  # that blind units give
        self.kernels: set[str] = set()  # units that are compiled functions
        for path in sorted(package.rglob("*.py")):
            module = path.relative_to(package).as_posix()
            tree = ast.parse(path.read_text(encoding="utf-8"))
            self.places[module] = []
            self._walk(tree.body, module, "", _imported(tree, package))

    def _walk(self, body: Iterable[ast.stmt], module: str, prefix: str, known: dict) -> None:
        for node in body:
            if isinstance(node, ast.ClassDef):
                self._walk(node.body, module, f"{prefix}{node.name}.", known)
            elif isinstance(node, ast.FunctionDef) and not _compiled(node):
                self._function(node, module, f"{module}:{prefix}{node.name}", known)
            else:
                stored = (n for n in ast.walk(node) if isinstance(n, ast.Name))
                names = [n.id for n in stored if isinstance(n.ctx, ast.Store)]
                if isinstance(node, ast.FunctionDef):
                    names = [node.name]
                unit = f"{module}:{prefix}{names[0] if names else ''} line {node.lineno}"
                first = min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", []))])
                self.places[module].append((first, node.end_lineno or first, unit))
                if isinstance(node, ast.FunctionDef):
                    self.kernels.add(unit)
                # What stands in a class is used through the class
                self.names[unit] = [prefix.partition(".")[0]] if prefix else names
                self._uses(ast.walk(node), unit, module, known)

    def _function(self, node: ast.FunctionDef, module: str, name: str, known: dict) -> None:
        inner = [s for s in ast.walk(node) if isinstance(s, ast.stmt) and s is not node]
        inner = sorted((s for s in inner if not _text(s)), key=lambda s: (s.lineno, s.col_offset))
        for k, statement in enumerate(inner):
            unit = f"{name} {k}"
            self.places[module].append((statement.lineno, statement.end_lineno or 0, unit))
            self.marks[module, statement.lineno, statement.col_offset] = len(self.marked)
            self.marked.append(unit)
            own = [c for c in ast.iter_child_nodes(statement) if not _has_statements(c)]
            self._uses((n for c in own for n in ast.walk(c)), unit, module, known)
        if inner:  # defaults and decorators belong to the first statement
            head = [node.args, *node.decorator_list]
            first = min(node.lineno, *(d.lineno for d in node.decorator_list), node.lineno)
            self.places[module].append((first, inner[0].lineno - 1, f"{name} 0"))
            self._uses((n for h in head for n in ast.walk(h)), f"{name} 0", module, known)

    def _uses(self, nodes: Iterable[ast.AST], unit: str, module: str, known: dict) -> None:
        for node in nodes:
            if isinstance(node, ast.Name | ast.Attribute):
                name = node.id if isinstance(node, ast.Name) else node.attr
                self.users[known.get(name, module), name].add(unit)

    def is_field(self, module: str, line: int) -> bool:
        """Whether a line stands in the body of a class."""
        here = [place for place in self.places[module] if place[0] <= line <= place[1]]
        return any(self.names.get(unit) and "." in unit.partition(":")[2] for _, _, unit in here)

    def depending(self, module: str, line: int) -> set[str]:
        """The innermost unit on a line; of a blind one also all that use it, up to statements."""
        here = [place for place in self.places[module] if place[0] <= line <= place[1]]
        found, todo = set(), [max(here)[2]] if here else []
        while todo:
            unit = todo.pop()
            if unit not in found:
                found.add(unit)
                for name in self.names.get(unit, []):
                    todo += self.users[unit.partition(":")[0], name]
        return found

    def mark(self, source: bytes, module: str) -> ast.Module:
        """A source in which each statement of a function is noted before it runs."""
        tree = ast.parse(source)
        for node in ast.walk(tree):
            for field in ("body", "orelse", "finalbody"):
                block = getattr(node, field, None)
                if isinstance(block, list):
                    setattr(node, field, [new for s in block for new in self._noted(s, module)])
        return tree

    def _noted(self, statement: ast.stmt, module: str) -> list[ast.stmt]:
        number = self.marks.get((module, statement.lineno, statement.col_offset))
        if number is None or _text(statement):
            return [statement]
        (mark,) = ast.parse(f"__reached__[{number}] = 1").body
        for node in ast.walk(mark):
            ast.copy_location(node, statement)
        return [mark, statement]


def _compiled(node: ast.FunctionDef) -> bool:
    return any("njit" in ast.unparse(d) for d in node.decorator_list)


def _text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _has_statements(node: ast.AST) -> bool:
    return isinstance(node, ast.stmt | ast.ExceptHandler | ast.match_case)


def _imported(tree: ast.Module, package: Path) -> dict[str, str]:
    """Of the names that a module imports from the package the module they come from; for a module
    that is imported itself its own names follow as attributes."""
    known = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(PACKAGE):
            base = "/".join((node.module or "").split(".")[1:])
            for alias in node.names:
                inner = package / base / f"{alias.name}.py"
                if not inner.is_file():
                    known[alias.asname or alias.name] = f"{base}.py"
                else:
                    own = inner.relative_to(package).as_posix()
                    names = ast.walk(ast.parse(inner.read_text(encoding="utf-8")))
                    defined = (getattr(n, "name", getattr(n, "id", None)) for n in names)
                    known |= {n: own for n in defined if isinstance(n, str)} | known
    return known


class Trace:
    """Plugin of pytest: notes of each test if it passes, its processor time and its statements;
    `shared`: the time of fixtures and cached functions that an earlier test paid, and which it
    takes itself where it runs alone."""

    def __init__(self, package: Path, units: Units) -> None:
        self.seen = builtins.__reached__ = bytearray(len(units.marked))  # type: ignore[attr-defined]
        self.fixtures: dict[Any, tuple[bytearray, float, str]] = {}
        self.now, self.shared, self.emptied = "", 0.0, 0
        self.tests: dict[str, dict[str, Any]] = {}
        usual = SourceFileLoader.get_code

        def get_code(loader: SourceFileLoader, name: str):
            path = Path(loader.get_filename(name))
            if not path.is_relative_to(package):
                return usual(loader, name)
            tree = units.mark(path.read_bytes(), path.relative_to(package).as_posix())
            return compile(tree, str(path), "exec", dont_inherit=True)

        SourceFileLoader.get_code = get_code  # type: ignore[method-assign]
        functools.lru_cache = self._noting(functools.lru_cache)
        functools.cache = self._noting(functools.cache)

    def _noting(self, cache: Callable[..., Any]) -> Callable[..., Any]:
        """A decorator of `functools`, whose function counts as run where its result is used."""

        def of(function, decorate):
            own, paid = bytearray(len(self.seen)), {"s": 0.0, "by": "", "added": -1}

            @functools.wraps(function)
            def run(*args, **keys):
                begin = time.process_time()
                try:
                    return self._run(own, function, args, keys)
                finally:
                    paid.update(s=time.process_time() - begin, by=self.now)

            cached = decorate(run)

            @functools.wraps(function)
            def use(*args, **keys):
                result = cached(*args, **keys)
                if paid["by"] != self.now:
                    self.shared += paid["s"]
                    paid["by"] = self.now
                if paid["added"] != self.emptied:  # else they are there; some are called often
                    self._add(own)
                    paid["added"] = self.emptied
                return result

            use.cache_clear, use.cache_info = cached.cache_clear, cached.cache_info
            return use

        def noting(*args, **keys):
            if args and callable(args[0]):
                return of(args[0], cache)
            return lambda function: of(function, cache(*args, **keys))

        return noting

    def _run(self, own: bytearray, function: Callable[..., Any], args: Any, keys: Any) -> Any:
        before = self._empty()
        try:
            return function(*args, **keys)
        finally:
            own[:] = _either(own, self.seen)
            self._add(before)

    def _empty(self) -> bytes:
        before = bytes(self.seen)
        self.seen[:] = bytes(len(before))
        self.emptied += 1
        return before

    def _add(self, other: bytes | bytearray) -> None:
        self.seen[:] = _either(self.seen, other)

    @pytest.hookimpl(hookwrapper=True)
    def pytest_fixture_setup(self, fixturedef):
        before, begin = self._empty(), time.process_time()
        yield
        took = time.process_time() - begin
        self.fixtures[fixturedef] = bytearray(self.seen), took, self.now
        self._add(before)

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item):
        self._empty()
        self.now, self.shared, begin = item.nodeid, 0.0, time.process_time()
        yield
        self.tests[item.nodeid]["seconds"] = time.process_time() - begin
        self.tests[item.nodeid]["shared"] = self.shared
        self.tests[item.nodeid]["statements"] = [k for k, one in enumerate(self.seen) if one]

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_teardown(self, item) -> None:
        for definition in item._request._fixture_defs.values():
            seen, took, by = self.fixtures.get(definition, (b"", 0.0, self.now))
            self._add(seen)
            self.shared += took if by != self.now else 0.0

    def pytest_runtest_logreport(self, report) -> None:
        test = self.tests.setdefault(report.nodeid, {"passed": False})
        if report.when == "call":
            test["passed"] = report.passed


def _either(one: bytes | bytearray, other: bytes | bytearray) -> bytes:
    both = int.from_bytes(one, "little") | int.from_bytes(other, "little")
    return both.to_bytes(len(one), "little")


class Chosen:
    """Plugin of pytest: runs chosen tests in their order, each within its limit of processor time;
    an endless loop in compiled code ends the process. No test begins after `until`, in processor
    time of the process: a fixture that several tests share counts for the first of them alone."""

    def __init__(self, limits: dict[str, float], until: float) -> None:
        self.limits, self.until, self.failed, self.late = limits, until, "", False

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item) -> bool | None:
        self.late = self.late or time.process_time() > self.until
        return True if self.late else None

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items) -> None:
        order = {name: k for k, name in enumerate(self.limits)}
        items[:] = sorted((i for i in items if i.nodeid in order), key=lambda i: order[i.nodeid])

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        signal.setitimer(signal.ITIMER_PROF, self.limits[nodeid])

    def pytest_runtest_logreport(self, report) -> None:
        if report.failed:
            self.failed = report.nodeid
