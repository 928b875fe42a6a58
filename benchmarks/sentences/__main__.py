"""Does what the project says hold? Monte Carlo of every sentence, interval and alarm.

    python -m benchmarks.sentences                 # all subjects, 100 recordings a case: hours
    python -m benchmarks.sentences lines --runs 20 # one subject, quicker

Prints Markdown. Runs of 100 recordings or more, and others with --write, also write
docs/accuracy/<subject>.csv, whose column `at 8b8d0af` stays, and, of all such files,
docs/accuracy.md.
"""

from __future__ import annotations

import argparse
import ast
import csv
import importlib
import time
from pathlib import Path

from benchmarks import ROOT

HERE = Path(__file__).parent
FOLDER = ROOT / "docs" / "accuracy"
COLUMNS = ("case", "statistic", "runs", "reach", "at 8b8d0af", "measured")
RUNS = 100
HEAD = """# Accuracy

Intervals, alarms and detections in simulated recordings, whose truth is known. `reach` is the goal;
`at 8b8d0af` is the same study before these checks existed. `make accuracy` computes all tables and
takes hours; `make accuracy ARGS=SUBJECT` computes one.
"""


def main() -> None:
    """Run the subjects that are named, or all."""
    known = sorted(p.stem for p in HERE.glob("[a-z]*.py"))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("subjects", nargs="*", choices=[*known, []], help="default: all")
    parser.add_argument("--runs", type=int, default=RUNS, help=f"a case; default {RUNS}")
    parser.add_argument("--write", action="store_true", help="keep the tables of fewer, too")
    asked = parser.parse_args()
    for subject in asked.subjects or known:
        begun = time.monotonic()
        module = importlib.import_module(f"benchmarks.sentences.{subject}")
        then = {(row["case"], row["statistic"]): row["at 8b8d0af"] for row in stored(subject)}
        rows = [
            dict(zip(COLUMNS, (*own, then.get((own[0], own[1]), ""), measured), strict=True))
            for *own, measured in module.rows(asked.runs)
        ]
        print(f"\n## {subject} ({time.monotonic() - begun:.0f} s)\n\n{module.__doc__.strip()}\n")
        print(markdown(rows), flush=True)
        if asked.write or asked.runs >= RUNS:
            FOLDER.mkdir(parents=True, exist_ok=True)
            with (FOLDER / f"{subject}.csv").open("w", newline="", encoding="utf-8") as file:
                writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
                writer.writeheader()
                writer.writerows(rows)
            FOLDER.with_suffix(".md").write_text(page(), encoding="utf-8")


def stored(subject: str) -> list[dict[str, str]]:
    """The table that was kept; its column `at 8b8d0af` remains."""
    path = FOLDER / f"{subject}.csv"
    if not path.exists():
        return []
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def markdown(rows: list[dict[str, object]]) -> str:
    """A table."""
    lines = [f"| {' | '.join(COLUMNS)} |", f"|{'---|' * len(COLUMNS)}"]
    return "\n".join([*lines, *(f"| {' | '.join(map(str, row.values()))} |" for row in rows)])


def page() -> str:
    """docs/accuracy.md, out of the tables that were kept."""
    parts = [HEAD]
    for path in sorted(FOLDER.glob("*.csv")):
        text = ast.get_docstring(ast.parse((HERE / f"{path.stem}.py").read_text("utf-8"))) or ""
        parts.append(f"## {path.stem}\n\n{text}\n\n{markdown(stored(path.stem))}\n")
    return "\n".join(parts)


if __name__ == "__main__":
    main()
