"""Which tests reach a line: functions that each test calls, from one traced run, and the names of
constants and compiled functions, which no trace sees, in those that use them.

It is also the plugin of pytest that traces (`REACH_WRITE`), or runs listed tests in their order
(`REACH_RUN`), each within a limit of seconds; an endless loop in compiled code ends the process.
"""

from __future__ import annotations

import ast
import json
import os
import signal
import sys
import threading
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

import pytest

PACKAGE = "mocap_metrology"
LIMITS: dict[str, int] = json.loads(os.environ.get("REACH_RUN", "{}"))


class Trace:
    """Notes of each test how long it takes and which functions of the package it calls."""

    def __init__(self, file: Path) -> None:
        self.file, self.seen, self.tests = file, set(), {}

    def __call__(self, frame, event, arg) -> None:
        code = frame.f_code
        self.seen.add((code.co_filename, code.co_qualname))

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item):
        self.seen = set()
        threading.settrace(self)
        sys.settrace(self)
        yield
        sys.settrace(None)
        functions = {
            f"{path.partition(f'/src/{PACKAGE}/')[2]}:{name.replace('.<locals>', '')}"
            for path, name in self.seen
            if f"/src/{PACKAGE}/" in path
        }
        self.tests.setdefault(item.nodeid, {})["functions"] = sorted(functions)

    def pytest_runtest_logreport(self, report) -> None:
        test = self.tests.setdefault(report.nodeid, {"seconds": 0.0, "passed": False})
        test["seconds"] += report.duration
        if report.when == "call":
            test["passed"] = report.passed

    def pytest_sessionfinish(self) -> None:
        self.file.write_text(json.dumps(self.tests))


def pytest_configure(config) -> None:
    if "REACH_WRITE" in os.environ:
        config.pluginmanager.register(Trace(Path(os.environ["REACH_WRITE"])))


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items) -> None:
    if LIMITS:
        order = {name: k for k, name in enumerate(LIMITS)}
        items[:] = sorted((i for i in items if i.nodeid in order), key=lambda i: order[i.nodeid])


def pytest_runtest_logstart(nodeid: str) -> None:
    if LIMITS:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(LIMITS[nodeid])


class Units:
    """Functions, and statements outside of functions, of the package, with the names they use."""

    def __init__(self, package: Path) -> None:
        self.places: dict[str, list[tuple[int, int, str]]] = {}
        self.users: dict[tuple[str, str], set[str]] = defaultdict(set)  # of (module, name)
        self.blind: set[str] = set()  # which a trace does not see
        self.names: dict[str, list[str]] = {}
        for path in sorted(package.rglob("*.py")):
            module = path.relative_to(package).as_posix()
            tree = ast.parse(path.read_text(encoding="utf-8"))
            self.places[module] = []
            self._walk(tree.body, module, "", _imported(tree, package))

    def _walk(self, body: Iterable[ast.stmt], module: str, prefix: str, known: dict) -> None:
        for node in body:
            if isinstance(node, ast.ClassDef):
                self._walk(node.body, module, f"{prefix}{node.name}.", known)
                continue
            if isinstance(node, ast.FunctionDef):
                unit, names = f"{module}:{prefix}{node.name}", [node.name]
                blind = any("njit" in ast.unparse(d) for d in node.decorator_list)
            else:
                stored = [n for n in ast.walk(node) if isinstance(n, ast.Name)]
                names = [n.id for n in stored if isinstance(n.ctx, ast.Store)]
                unit, blind = f"{module}:{prefix}line {node.lineno}", True
            first = min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", []))])
            self.places[module].append((first, node.end_lineno or first, unit))
            # What stands in a class is used through the class
            self.names[unit] = [prefix.partition(".")[0]] if prefix and blind else names
            self.blind |= {unit} if blind else set()
            for inner in ast.walk(node):
                if isinstance(inner, ast.Name | ast.Attribute):
                    name = inner.id if isinstance(inner, ast.Name) else inner.attr
                    self.users[known.get(name, module), name].add(unit)

    def of(self, module: str, line: int) -> list[str]:
        """Functions and statements on a line."""
        return [unit for first, last, unit in self.places[module] if first <= line <= last]

    def traced(self, module: str, line: int) -> set[str]:
        """Functions that a trace sees and that a change on this line can reach."""
        found, todo = set(), self.of(module, line)
        while todo:
            unit = todo.pop()
            if unit not in found:
                found.add(unit)
                if unit in self.blind:
                    for name in self.names[unit]:
                        todo += self.users[unit.partition(":")[0], name]
        return found - self.blind


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
