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


def command(target: str, arguments: list[str]) -> list[str]:
    """The call of Snakemake; arguments come last, as `--config` takes all that follows it."""
    return [sys.executable, "-m", "snakemake", "--report", target, *arguments]


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
    parser = argparse.ArgumentParser(prog="write_report.py", description=__doc__.splitlines()[0])
    parser.add_argument("target", help="the report to write, as results/report.html")
    what = "all arguments that the run had, as --profile profiles/quick"
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help=what)
    options = parser.parse_args(arguments)
    return write(options.target, options.arguments)


def write(target: str, arguments: list[str]) -> int:
    """Write the report; 1 and one line on stderr where there is none."""
    done = subprocess.run(
        command(target, arguments),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode:
        print(f"no report: {why(done.stdout)}", file=sys.stderr)
        return 1
    if not Path(target).is_file():
        print(f"no report: {FINISH}", file=sys.stderr)
        return 1
    if NOTHING.encode() in Path(target).read_bytes():
        Path(target).unlink()
        print(f"no report: the summary is missing: {FINISH}", file=sys.stderr)
        return 1
    print(f"{target}: {Path(target).stat().st_size / 1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
