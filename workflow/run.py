"""Snakemake, after what a killed run left is cleared: `python workflow/run.py --cores 2 [...]`.

Every argument is Snakemake's. From here on this process does what `snakemake` does.
"""

from __future__ import annotations

import contextlib
import runpy
import signal
import subprocess
import sys

# Ctrl-C is for one thread, see `ends_at_interrupt`; those that numpy starts inherit this.
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})

from mocap_workflow import runs  # noqa: E402

from mocap_metrology.common.faults import Faults, stop  # noqa: E402

SNAKEMAKE = (sys.executable, "-m", "snakemake")


def main(arguments: list[str]) -> None:
    def unlock() -> bool:
        command = [*SNAKEMAKE, "--unlock", *arguments]
        done = subprocess.run(command, capture_output=True, check=False, text=True)
        if done.returncode:  # why, as a fault in the configuration
            sys.stderr.write(done.stderr)
        return not done.returncode

    runs.ends_at_interrupt()
    try:
        with runs.alone():
            runs.clear(unlock)
            with contextlib.suppress(OSError):  # Snakemake will report what is wrong there
                runs.began()
    except Faults as faults:
        stop(faults)
    sys.argv = ["snakemake", *arguments]
    runpy.run_module("snakemake", run_name="__main__")  # as `python -m snakemake`, in this process


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except KeyboardInterrupt:  # before jobs are started; then Snakemake itself ends
        print("Interrupted", file=sys.stderr)
    finally:
        runs.ends_as_interrupted()
