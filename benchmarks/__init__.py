"""Studies behind the numbers of docs/: `python -m benchmarks.NAME`, one thread a process."""

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
for pool in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{pool}_NUM_THREADS", "1")
sys.path.insert(0, str(ROOT / "workflow"))  # twins are read there


def arguments(doc: str | None, **defaults: Any) -> dict[str, Any]:
    """Arguments of a study by name, each of the kind of its default and optional; a tuple is the
    rest of them. `--help` prints doc."""
    how = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=doc, formatter_class=how)
    for name, default in defaults.items():
        many, kind = ("*", str) if isinstance(default, tuple) else ("?", type(default))
        said = f"default: {' '.join(default) if many == '*' else default}"
        parser.add_argument(name, nargs=many, type=kind, default=default, help=said)
    return vars(parser.parse_args())


def head(*names: str) -> None:
    """Print the head of a table of Markdown."""
    line(*names)
    print("|---" * len(names) + "|", flush=True)


def line(*cells: object) -> None:
    """Print a row."""
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def cpu_s(work: Callable[[], object], times: int = 5) -> float:
    """Least CPU seconds of some calls."""
    seconds = []
    for _ in range(times):
        begun = time.process_time()
        work()
        seconds.append(time.process_time() - begun)
    return min(seconds)
