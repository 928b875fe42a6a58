"""`snakemake --lint`, of which one message is expected: `python workflow/lint.py`.

The environment of all rules is the locked `.venv` of `make env`, and no rule names another.
"""

from __future__ import annotations

import re
import subprocess
import sys

EXPECTED = "Specify a conda environment or container for each rule."
TITLE = re.compile(r"^ +\* (.+?):?$", re.MULTILINE)


def unexpected(said: str) -> list[str]:
    """What is complained of beside the expected, each once."""
    return [title for title in dict.fromkeys(TITLE.findall(said)) if title != EXPECTED]


def main() -> int:
    command = [sys.executable, "-m", "snakemake", "--lint", *sys.argv[1:]]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if not done.returncode or (TITLE.search(done.stdout) and not unexpected(done.stdout)):
        return 0
    print(done.stdout, end="", file=sys.stderr)
    print("\n".join(unexpected(done.stdout)), file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
