"""Write Snakemake's report of a finished run: what `make report` does last.

    python workflow/write_report.py results/report.html [arguments of the run]

Of Snakemake's output only what is wrong is shown, in one line.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from pathlib import Path

MISSING = re.compile(r"File (\S+) marked for report but does not exist")
NOTHING = "There is no summary here"  # text of report/workflow.rst then
FINISH = "the run did not finish; call `make`, correct what it reports, and try again"
FAULT = re.compile(r"\w+(Error|Exception)\b")


def why(output: str) -> str:
    """One line from Snakemake's message on a report that it could not write."""
    missing = MISSING.search(output)
    if missing:
        return f"{missing[1]} is missing: {FINISH}"
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    faults = [k for k, line in enumerate(lines) if FAULT.match(line)]
    if not faults:
        return lines[-1] if lines else FINISH
    said = " ".join(lines[faults[0] : faults[0] + 3])
    return FINISH if said.startswith("FileNotFoundError") else said


def main(arguments: list[str] | None = None) -> int:
    """Write the report; 1 and one line on stderr where there is none."""
    parser = argparse.ArgumentParser(prog="write_report.py", description=__doc__.splitlines()[0])
    parser.add_argument("target", type=Path, help="the report to write, as results/report.html")
    what = "all arguments that the run had, as --profile profiles/quick"
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help=what)
    options = parser.parse_args(arguments)
    target, problem = options.target, ""
    # Arguments come last, as `--config` takes all that follows it
    command = [sys.executable, "-m", "snakemake", "--report", str(target), *options.arguments]
    done = subprocess.run(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode:
        problem = why(done.stdout)
    elif not target.is_file():
        problem = FINISH
    elif NOTHING.encode() in target.read_bytes():
        target.unlink()
        problem = f"the summary is missing: {FINISH}"
    if problem:
        print(f"no report: {problem}", file=sys.stderr)
        return 1
    print(f"{target}: {target.stat().st_size / 1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
