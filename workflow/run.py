"""Snakemake, after what a killed run left is cleared: `python workflow/run.py --cores 2 [...]`.

Every argument is Snakemake's. From here on this process is Snakemake itself.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys

from mocap_workflow import runs
from mocap_workflow.faults import Faults, stop

SNAKEMAKE = (sys.executable, "-m", "snakemake")


def main(arguments: list[str]) -> None:
    def unlock() -> bool:
        command = [*SNAKEMAKE, "--unlock", *arguments]
        return not subprocess.run(command, capture_output=True, check=False).returncode

    try:
        runs.clear(unlock)
        with contextlib.suppress(OSError):  # Snakemake will say what is wrong with the folder
            runs.began()
    except Faults as faults:
        stop(faults)
    os.execv(sys.executable, [*SNAKEMAKE, *arguments])


if __name__ == "__main__":
    main(sys.argv[1:])
