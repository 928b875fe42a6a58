"""`python -m tests.mutants --seed 1 --number 300`: survivors of a seeded sample of changes.

A line of the rooms is drawn, each once at most, then one of its changes. Each runs in a copy of the
project, with the tests that reach its function, fastest first, then the others of their files,
until one fails. Results and the map of tests to functions are stored in build/mutants, so that an
interrupted run continues; `--survivors` runs only what survived before.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import os
import random
import shutil
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Queue
from typing import Any

from .changes import Change, apply, changes
from .reach import PACKAGE, Units

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "build/mutants"
SOURCES = f"src/{PACKAGE}"
ROOMS = ["common", "io", "noise", "lighthouse"]
TESTS = ["frozen", *ROOMS, "steps", "present", "cli"]  # what stands on the rooms sees them, too
START_S, COMPILE_S = 20.0, 100.0  # more than thrice its usual time of a test: kernels anew
Mutant = tuple[str, Change]


def run_tests(tree: Path, files: list[str], limit_s: float, **settings: str) -> str:
    """Output of pytest in a copy of the project; empty if it did not end in time."""
    options = ["-p", "tests.mutants.reach", "-p", "no:cacheprovider", "--tb=line"]
    options += ["-x"] if "REACH_RUN" in settings else []
    command = [sys.executable, "-m", "pytest", *options, *files]
    alone = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}
    paths = {"PYTHONPATH": f"{tree}/src:{tree}", "PYTHONDONTWRITEBYTECODE": "1"}
    beside = ROOT.parent / "shared/data"
    folder = str(beside if beside.is_dir() else ROOT / "samples")
    samples = {"MOCAP_SAMPLES": os.environ.get("MOCAP_SAMPLES", folder)}
    child = subprocess.Popen(
        command,
        cwd=tree,
        env={**os.environ, **alone, **paths, **samples, **settings},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    try:
        output = child.communicate(timeout=limit_s)[0]
        return "" if child.returncode == -signal.SIGALRM else output
    except subprocess.TimeoutExpired:
        os.killpg(child.pid, signal.SIGKILL)
        child.communicate()
        return ""


def copy_tree(tree: Path) -> None:
    """A copy of the project that has the kernels compiled."""
    tree.mkdir(parents=True, exist_ok=True)
    leave = shutil.ignore_patterns("__pycache__", ".compiled")
    for part in ("src", "tests", "workflow", "config", "docs", "benchmarks", "profiles"):
        for old in (tree / part).rglob("*.py"):
            if not (ROOT / old.relative_to(tree)).exists():
                old.unlink()
        shutil.copytree(ROOT / part, tree / part, ignore=leave, dirs_exist_ok=True)
    for name in ("pyproject.toml", "Makefile", "Snakefile", "README.md", "CONTRIBUTING.md"):
        shutil.copy2(ROOT / name, tree / name)
    for command in (["compileall", "-q", f"{tree}/src"], [f"{PACKAGE}.common.compiled"]):
        env = {**os.environ, "PYTHONPATH": f"{tree}/src"}
        subprocess.run([sys.executable, "-m", *command], check=True, env=env)


def traced_tests(trees: list[Path], folders: list[str]) -> dict[str, dict[str, Any]]:
    """Of each test that passes: seconds, and the functions that it calls. A file of tests is traced
    again when its content has changed."""
    stored, lock = FOLDER / "reach.json", threading.Lock()
    known = json.loads(stored.read_text()) if stored.is_file() else {}
    paths = sorted(p for name in folders for p in (ROOT / "tests" / name).rglob("test_*.py"))
    now = {
        p.relative_to(ROOT).as_posix(): hashlib.sha256(p.read_bytes()).hexdigest() for p in paths
    }
    changed = [name for name in now if known.get(name, {}).get("sha256") != now[name]]
    parts = [changed[k : k + 12] for k in range(0, len(changed), 12)]

    def trace(k: int) -> None:
        for names in parts[k :: len(trees)]:
            written = trees[k] / "traced.json"
            written.unlink(missing_ok=True)
            run_tests(trees[k], names, 3600.0, REACH_WRITE=str(written))
            found = json.loads(written.read_text()) if written.is_file() else {}
            with lock:
                for name in names:
                    own = {t: v for t, v in found.items() if t.partition("::")[0] == name}
                    known[name] = {"sha256": now[name], "tests": own}
                stored.write_text(json.dumps(known))
            print(f"traced {len(found)} tests of {', '.join(names)}", flush=True)

    with ThreadPoolExecutor(len(trees)) as pool:
        list(pool.map(trace, range(len(trees))))
    tests = [known[name]["tests"].items() for name in now]
    return {test: value for part in tests for test, value in part if value.get("passed")}


def sample(seed: int, number: int) -> list[Mutant]:
    """Seeded changes: of lines drawn without replacement one change each."""
    draw = random.Random(seed)
    lines: dict[tuple[str, int], list[Change]] = {}
    for room in ROOMS:
        for path in sorted((ROOT / SOURCES / room).rglob("*.py")):
            name = path.relative_to(ROOT / SOURCES).as_posix()
            for change in changes(path.read_text(encoding="utf-8")):
                lines.setdefault((name, change.line), []).append(change)
    drawn = draw.sample(sorted(lines), min(number, len(lines)))
    return [(name, draw.choice(lines[name, line])) for name, line in drawn]


def reaching(units: Units, tests: dict[str, dict[str, Any]], mutant: Mutant) -> list[str]:
    """Tests that reach a mutant, fastest first, then the others of their files, which may use
    results that one of them has stored; those of tests/frozen use their own only."""
    functions = units.traced(mutant[0], mutant[1].line)

    def inside(name: str) -> bool:
        return any(name == f or name.startswith(f"{f}.") for f in functions)

    reach = {t for t, v in tests.items() if any(inside(f) for f in v["functions"])}
    files = {t.partition("::")[0] for t in reach}
    files = {name for name in files if not name.startswith("tests/frozen/")}
    near = [t for t in tests if t in reach or t.partition("::")[0] in files]
    return sorted(near, key=lambda t: (t not in reach, tests[t]["seconds"]))


def kernels_for(tree: Path, mutant: str) -> bool:
    """Whether a changed source has compiled kernels; a cache that lacks those of it and of what
    imports it is then made.

    Their folder is named by the sources, so a change of one file would compile all of them."""
    package = tree / SOURCES
    texts = {p: p.read_text(encoding="utf-8") for p in package.rglob("*.py")}
    if "common.compiled import njit" not in texts[package / mutant]:
        return False
    stale, todo = set(), [package / mutant]
    while todo:
        path = todo.pop()
        if path not in stale:
            stale.add(path)
            dotted = ".".join(path.relative_to(package).with_suffix("").parts)
            base, _, last = dotted.rpartition(".")
            words = (f"{PACKAGE}.{dotted} import", f"from {PACKAGE}.{base} import {last}")
            todo += [p for p, t in texts.items() if any(w in t for w in words)]
    command = f"from {PACKAGE}.common.compiled import sources_hash; print(sources_hash())"
    env = {**os.environ, "PYTHONPATH": f"{tree}/src"}
    done = subprocess.run([sys.executable, "-c", command], env=env, capture_output=True, text=True)
    new = package / ".compiled" / done.stdout.strip().rpartition("\n")[2]
    names = [f"{path.stem}.*" for path in stale]
    first = package / ".compiled" / (tree / "kernels").read_text()
    shutil.copytree(first, new, ignore=shutil.ignore_patterns(*names), dirs_exist_ok=True)
    return True


def judge(tree: Path, mutant: Mutant, chosen: dict[str, float]) -> tuple[str, str]:
    """What became of a mutant: killed, and by which test; stopped (no end in time); survived."""
    name, change = mutant
    path, caches = tree / SOURCES / name, tree / SOURCES / ".compiled"
    source, times = path.read_text(encoding="utf-8"), path.stat()
    before = {p.name for p in caches.iterdir()}
    path.write_text(apply(source, change), encoding="utf-8")
    try:
        spare = START_S + (COMPILE_S if kernels_for(tree, name) else 0.0)
        files = sorted({t.partition("::")[0] for t in chosen})
        limits = {test: math.ceil(spare + 3 * seconds) for test, seconds in chosen.items()}
        total = 2 * COMPILE_S + 3 * sum(chosen.values())
        output = run_tests(tree, files, total, REACH_RUN=json.dumps(limits))
    finally:
        path.write_text(source, encoding="utf-8")
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
        for new in {p.name for p in caches.iterdir()} - before:
            shutil.rmtree(caches / new, ignore_errors=True)
    if not output:
        return "stopped", ""
    if " passed" in (last := output.strip().rpartition("\n")[2]) and "failed" not in last:
        return ("killed", last) if "error" in last else ("survived", "")
    by = [line for line in output.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return "killed", (by or [last])[0]


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--number", type=int, default=300)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--longest", type=float, default=120.0, help="seconds of tests a mutant")
    parser.add_argument("--tests", nargs="+", default=TESTS, help="folders of tests")
    parser.add_argument("--survivors", action="store_true", help="only what survived before")
    arguments = parser.parse_args()
    trees = [FOLDER / f"tree{k}" for k in range(arguments.workers)]
    for tree in trees:
        copy_tree(tree)
        caches = [p for p in (tree / SOURCES / ".compiled").iterdir() if p.is_dir()]
        (tree / "kernels").write_text(max(caches, key=lambda p: p.stat().st_mtime).name)
    tests, units = traced_tests(trees, arguments.tests), Units(ROOT / SOURCES)
    stored = FOLDER / f"seed{arguments.seed}.json"
    results = json.loads(stored.read_text()) if stored.is_file() else {}
    free: Queue[Path] = Queue()
    for tree in trees:
        free.put(tree)
    lock = threading.Lock()

    def run(mutant: Mutant) -> None:
        name, change = mutant
        key = f"{name}:{change.line}: {change.old} -> {change.new} at {change.start}"
        before = results.get(key)
        if before and not (arguments.survivors and before["outcome"] == "survived"):
            return
        chosen: dict[str, float] = {}
        for test in reaching(units, tests, mutant):
            if sum(chosen.values()) + tests[test]["seconds"] > arguments.longest:
                break
            chosen[test] = tests[test]["seconds"]
        tree, begin = free.get(), time.monotonic()
        try:
            outcome, by = judge(tree, mutant, chosen) if chosen else ("survived", "")
        finally:
            free.put(tree)
        line = (ROOT / SOURCES / name).read_text().splitlines()[change.line - 1].strip()
        with lock:
            results[key] = {"outcome": outcome, "by": by, "tests": len(chosen), "text": line}
            stored.write_text(json.dumps(results, indent=1))
            seconds = time.monotonic() - begin
            print(f"{outcome:9}{seconds:6.0f} s {len(chosen):5} tests  {key}", flush=True)

    with ThreadPoolExecutor(arguments.workers) as pool:
        list(pool.map(run, sample(arguments.seed, arguments.number)))
    alive = {k: v for k, v in results.items() if v["outcome"] == "survived"}
    print(f"\n{len(alive)} of {len(results)} survive (seed {arguments.seed})\n")
    print("| change | line | tests |\n|---|---|---|")
    for key, value in sorted(alive.items()):
        print(f"| {key} | `{value['text']}` | {value['tests']} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
