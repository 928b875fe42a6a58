"""`python -m tests.mutants --seed 1 --number 300`: survivors of a seeded sample of changes.

A line of the rooms is drawn, each once at most, then one of its changes. Each runs in a copy of
the project, with the tests that run its statement, quickest first, until one fails. Processes are
forked from one that has imported the libraries; compiled functions that no change reaches are
those of the copy. The drawn sample, what became of each, and the map of tests to statements are
stored in build/mutants, so that an interrupted run continues; the table there is written after
each mutant, in the order of the draw, so that the first so many are a random sample, too.
`--survivors` runs again what survived, on the lines as they stand now.
"""

import argparse
import hashlib
import importlib
import json
import multiprocessing
import os
import random
import runpy
import shutil
import signal
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest

from .changes import Change, apply, changes
from .reach import PACKAGE, Chosen, Trace, Units

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "build/mutants"
TREE = FOLDER / "tree"
SOURCES = TREE / f"src/{PACKAGE}"
ROOMS = ["common", "io", "noise", "lighthouse"]
# What stands on the rooms sees them, too, and the manual has the defaults of what users give
MANUAL = "workflow/test_document.py"
TESTS = ["frozen", *ROOMS, "steps", "present", "cli", MANUAL]
LIBRARIES = [
    *("numba", "pandas", "pyarrow.parquet", "pydantic", "ezc3d", "jinja2", "hypothesis", "yaml"),
    *("scipy.signal", "scipy.optimize", "scipy.stats", "scipy.ndimage", "scipy.interpolate"),
    *("scipy.spatial.transform", "scipy.sparse.linalg", "matplotlib.pyplot", "markdown_it"),
]
# More than thrice its usual time a test may take; until the first one begins; kernels anew
SPARE_S, START_S, COMPILE_S = 40.0, 5.0, 60.0
LONGEST_S = 1200.0  # of a mutant, on a busy machine; none takes that long but one that waits
FROZEN = 0.2  # weight of a second of tests/frozen, which notice more changes than other tests
STAGES_S = (4.0, 16.0, 64.0)  # of tests: few files are imported before one fails
Send = Callable[[Any], None]


def copy_tree() -> None:
    """A copy of the project, which later edits do not disturb."""
    leave = shutil.ignore_patterns("__pycache__", ".compiled")
    for part in ("src", "tests", "workflow", "config", "docs", "benchmarks", "profiles"):
        for old in (TREE / part).rglob("*.py"):
            if not (ROOT / old.relative_to(TREE)).exists():
                old.unlink()
        shutil.copytree(ROOT / part, TREE / part, ignore=leave, dirs_exist_ok=True)
    for name in ("pyproject.toml", "Makefile", "Snakefile", "README.md", "CONTRIBUTING.md"):
        shutil.copy2(ROOT / name, TREE / name)
    for name in LIBRARIES:
        importlib.import_module(name)
    alone = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}
    paths = {"PYTHONPATH": f"{TREE}/src:{TREE}", "XDG_CACHE_HOME": str(FOLDER / "cache")}
    beside = ROOT.parent / "shared/data"
    samples = os.environ.get("MOCAP_SAMPLES", beside if beside.is_dir() else ROOT / "samples")
    os.environ.update(alone | paths | {"MOCAP_SAMPLES": str(samples), "MPLBACKEND": "agg"})


def kernels(stale: Iterable[str] = ()) -> Any:
    """The module `common.compiled` of the copy, its folder filled with what is not stale."""
    # The time stamps of sources would have kernels compiled anew that no change reaches
    caching = importlib.import_module("numba.core.caching")
    caching._SourceFileBackedLocatorMixin.get_source_stamp = lambda self: (0, 0)
    compiled = importlib.import_module(f"{PACKAGE}.common.compiled")
    for made in (FOLDER / "kernels").glob("*"):
        shutil.rmtree(compiled.CACHE)
        shutil.copytree(
            made, compiled.CACHE, copy_function=os.link, ignore=shutil.ignore_patterns(*stale)
        )
    return compiled


def forked(work: Callable[[Send], None], limit_s: float) -> tuple[list[Any], int]:
    """What a function sends from a process of its own in the copy, and how that ended."""

    def begin() -> None:
        os.setsid()
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        os.chdir(TREE)
        sys.path[:0] = [f"{TREE}/src", str(TREE)]
        with (FOLDER / "output.txt").open("w") as stream:
            os.dup2(stream.fileno(), 1)
            os.dup2(stream.fileno(), 2)
        work(there.send)

    here, there = multiprocessing.Pipe(duplex=False)
    child = multiprocessing.get_context("fork").Process(target=begin)
    child.start()
    there.close()
    found, end = [], time.monotonic() + limit_s
    try:
        while here.poll(max(0.0, end - time.monotonic())):
            found.append(here.recv())
    except EOFError:
        child.join(10.0)
    finally:
        if child.is_alive():
            os.killpg(child.pid or 0, signal.SIGKILL)
            child.join()
    return found, child.exitcode or 0


def run_tests(files: list[str], plugin: Any, *options: str) -> int:
    quiet = ["-p", "no:cacheprovider", "--tb=line", *options]
    return int(pytest.main([*quiet, *files], plugins=[plugin]))


def warm() -> None:
    """Compile the kernels, once for all mutants of these sources."""

    def run(send: Send) -> None:
        compiled = importlib.import_module(f"{PACKAGE}.common.compiled")
        made = FOLDER / "kernels" / compiled.CACHE.name
        if not made.is_dir():
            shutil.rmtree(made.parent, ignore_errors=True)
            shutil.rmtree(compiled.CACHE)
            kernels().warm()
            shutil.copytree(compiled.CACHE, made)
        send(True)

    if not forked(run, 3600.0)[0]:
        sys.exit((FOLDER / "output.txt").read_text())


def store_results() -> None:
    """Store results of tests/frozen anew in the copy: other processors round otherwise."""
    sources = sorted([*SOURCES.rglob("*.py"), *(TREE / "tests/frozen").glob("*.py")])
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()[:16]
    made = FOLDER / "results" / digest

    def run(send: Send) -> None:
        kernels()
        sys.path.insert(0, f"{TREE}/tests")
        sys.argv[1:] = []
        runpy.run_module("frozen", run_name="__main__")
        shutil.copytree(TREE / "tests/frozen/stored", made)

    if not made.is_dir():
        shutil.rmtree(made.parent, ignore_errors=True)
        forked(run, 3600.0)
    shutil.copytree(made, TREE / "tests/frozen/stored", dirs_exist_ok=True)


def traced_tests(units: Units, folders: list[str]) -> dict[str, dict[str, Any]]:
    """Of each test that passes: seconds, and the statements that it runs. A file of tests is traced
    again when its content has changed; after changes of the package remove the map to be exact."""
    stored = FOLDER / "reach.json"
    known = json.loads(stored.read_text()) if stored.is_file() else {"marked": [], "files": {}}
    files: dict[str, Any] = known["files"]
    if known["marked"] != units.marked:
        at = {name: k for k, name in enumerate(units.marked)}
        moved = {k: at[name] for k, name in enumerate(known["marked"]) if name in at}
        for test in (test for file in files.values() for test in file["tests"].values()):
            test["statements"] = [moved[k] for k in test["statements"] if k in moved]
    tests = TREE / "tests"
    paths = sorted(
        p for name in folders for p in [*(tests / name).rglob("test_*.py"), tests / name]
    )
    now = {
        p.relative_to(TREE).as_posix(): hashlib.sha256(p.read_bytes()).hexdigest()
        for p in paths
        if p.is_file()
    }
    for folder in folders:
        part = [name for name in now if f"{name}/".startswith(f"tests/{folder}/")]
        part = [name for name in part if files.get(name, {}).get("sha256") != now[name]]

        def trace(send: Send, part: list[str] = part) -> None:
            kernels()
            for name in [name for name in sys.modules if name.partition(".")[0] == PACKAGE]:
                del sys.modules[name]  # to be imported with marks
            plugin = Trace(SOURCES, units)
            run_tests(part, plugin)
            send(plugin.tests)

        if part:
            begin = time.monotonic()
            found = next(iter(forked(trace, 7200.0)[0]), {})
            for name in part:
                own = {t: v for t, v in found.items() if t.partition("::")[0] == name}
                files[name] = {"sha256": now[name], "tests": own}
            stored.write_text(json.dumps({"marked": units.marked, "files": files}))
            taken = time.monotonic() - begin
            print(f"traced {len(found)} tests of {folder}: {taken:.0f} s", flush=True)
    tests = [files[name]["tests"].items() for name in now]
    return {test: value for part in tests for test, value in part if value["passed"]}


def sample(seed: int, number: int) -> list[dict[str, Any]]:
    """Seeded changes: of lines drawn without replacement one change each."""
    draw = random.Random(seed)
    lines: dict[tuple[str, int], list[Change]] = {}
    texts: dict[str, list[str]] = {}
    for room in ROOMS:
        for path in sorted((SOURCES / room).rglob("*.py")):
            name, source = path.relative_to(SOURCES).as_posix(), path.read_text(encoding="utf-8")
            texts[name] = source.splitlines()
            for change in changes(source):
                lines.setdefault((name, change.line), []).append(change)
    drawn = draw.sample(sorted(lines), min(number, len(lines)))
    return [
        {"module": name, **draw.choice(lines[name, line])._asdict(), "text": texts[name][line - 1]}
        for name, line in drawn
    ]


def change_of(mutant: dict[str, Any]) -> Change | None:
    """The change on its line as it stands now, which may have moved, or be gone."""
    path = SOURCES / mutant["module"]
    lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
    same = [k for k, line in enumerate(lines, 1) if line == mutant["text"]]
    if not same:
        return None
    mutant["line"] = min(same, key=lambda k: abs(k - mutant["line"]))
    return Change(*(mutant[name] for name in Change._fields))


def stages(chosen: dict[str, float]) -> list[dict[str, float]]:
    """Tests in parts of increasing length."""
    parts: list[dict[str, float]] = [{}]
    for test, seconds in chosen.items():
        limit = STAGES_S[min(len(parts), len(STAGES_S)) - 1]
        if parts[-1] and sum(parts[-1].values()) + seconds > limit:
            parts.append({})
        parts[-1][test] = seconds
    return parts


def judge(
    path: Path, change: Change, stale: list[str], chosen: dict[str, float], longest_s: float
) -> list[str]:
    """What became of a mutant: killed, and by which test; stopped (no end in time, or a crash);
    survived. Bytecode of all other files is there since the trace."""
    source, stamp = path.read_text(encoding="utf-8"), path.stat()
    compile_s = COMPILE_S if stale else 0.0
    spare = SPARE_S + compile_s

    def run(send: Send) -> None:
        sys.dont_write_bytecode = True
        kernels(stale)
        until = time.process_time() + longest_s + START_S + compile_s
        for part in stages(chosen):
            plugin = Chosen({test: spare + 3 * s for test, s in part.items()}, until)
            status = run_tests(sorted({t.partition("::")[0] for t in part}), plugin, "-x")
            if status not in (0, 5):  # 5: no test has this name any more
                return send(["killed", plugin.failed])
        return send(["survived", ""])

    shutil.rmtree(SOURCES / ".compiled", ignore_errors=True)
    path.write_text(apply(source, change), encoding="utf-8")
    try:
        found, end = forked(run, LONGEST_S)
    finally:
        path.write_text(source, encoding="utf-8")
        os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
    return found[0] if found else ["stopped", ""] if end < 0 else ["killed", "import"]


def table(title: str, mutants: list[dict[str, Any]]) -> str:
    """What became of the sample, and its survivors."""
    done = [m for m in mutants if m.get("outcome")]
    of = Counter("stored results" if "frozen" in m["by"] else m["outcome"] for m in done)
    alive = sorted((m for m in done if m["outcome"] == "survived"), key=lambda m: m["module"])
    said = ", ".join(f"{name} {count}" for name, count in sorted(of.items()))
    seconds = sum(m["seconds"] for m in done)
    head = f"{title}: {len(alive)} of {len(done)} survive ({said}; {seconds:.0f} s)\n\n"
    rows = (
        f"| {m['module']}:{m['line']} | `{m['old']}` | `{m['new']}` | `{m['text'].strip()}` |"
        f" {m['tests']} |\n"
        for m in alive
    )
    return f"{head}| place | old | new | line | tests |\n|---|---|---|---|---|\n{''.join(rows)}"


class Reach:
    """Tests of each statement, and compiled functions that depend on it."""

    def __init__(self, folders: list[str]) -> None:
        self.units = Units(SOURCES)
        tests = traced_tests(self.units, folders)
        self.seconds = {test: value["seconds"] for test, value in tests.items()}
        self.alone = {test: s + tests[test].get("shared", 0.0) for test, s in self.seconds.items()}
        self.running = defaultdict(list)
        for test, value in tests.items():
            for k in value["statements"]:
                self.running[self.units.marked[k]].append(test)

    def weight(self, test: str) -> float:
        return self.alone[test] * (FROZEN if "/frozen/" in test else 1.0)

    def tests(self, module: str, line: int, longest_s: float) -> dict[str, float]:
        """Tests that reach a line, and their seconds where they run alone, the quickest of these
        first, as many as the time allows."""
        units = self.units.depending(module, line)
        reached = {t for u in units for t in self.running[u]} or self.naming(Path(module).stem)
        if self.units.is_field(module, line):
            reached |= {test for test in self.seconds if MANUAL in test}
        chosen: dict[str, float] = {}
        for test in sorted(reached, key=self.weight):
            if sum(map(self.seconds.__getitem__, chosen)) + self.seconds[test] > longest_s:
                break
            chosen[test] = self.alone[test]
        return chosen

    def naming(self, name: str) -> set[str]:
        """Tests of files that name a module: some run it in processes of their own."""
        files = {test.partition("::")[0] for test in self.seconds}
        naming = {file for file in files if name in (TREE / file).read_text(encoding="utf-8")}
        return {test for test in self.seconds if test.partition("::")[0] in naming}

    def stale(self, module: str, line: int) -> list[str]:
        """Patterns of files of numba's cache."""
        units = self.units.depending(module, line) & self.units.kernels
        named = [(u.partition(":")[0], n) for u in units for n in self.units.names.get(u, [])]
        return [f"{Path(path).stem}.{name}-*" for path, name in named]


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--number", type=int, default=300)
    parser.add_argument("--longest", type=float, default=30.0, help="seconds of tests a mutant")
    parser.add_argument("--tests", nargs="+", default=TESTS, help="folders of tests")
    parser.add_argument("--survivors", action="store_true", help="only what survived before")
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    copy_tree()
    warm()
    store_results()
    reach = Reach(arguments.tests)
    stored = FOLDER / f"seed{arguments.seed}.json"
    drawn = stored.is_file()
    mutants = json.loads(stored.read_text()) if drawn else sample(arguments.seed, arguments.number)
    outcome = "survived" if arguments.survivors else None
    for mutant in [m for m in mutants if m.get("outcome") == outcome]:
        begin, change, module = time.monotonic(), change_of(mutant), mutant["module"]
        chosen: dict[str, float] = {}
        found = ["gone", ""]
        if change:
            chosen = reach.tests(module, change.line, arguments.longest)
            stale = reach.stale(module, change.line)
            found = ["survived", ""]
            if chosen:
                found = judge(SOURCES / module, change, stale, chosen, arguments.longest)
        seconds = time.monotonic() - begin
        mutant |= {"outcome": found[0], "by": found[1], "tests": len(chosen), "seconds": seconds}
        stored.write_text(json.dumps(mutants, indent=1))
        stored.with_suffix(".md").write_text(table(f"Seed {arguments.seed}", mutants))
        place = f"{module}:{mutant['line']} {mutant['old']} -> {mutant['new']}"
        print(
            f"{found[0]:9}{seconds:5.0f} s {len(chosen):5} tests  {place}  {found[1]}", flush=True
        )
    print(stored.with_suffix(".md").read_text())
    return 0


if __name__ == "__main__":
    sys.exit(main())
