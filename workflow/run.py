"""Snakemake, which Ctrl-C ends with its jobs in one line: `python workflow/run.py --cores 2 [...]`.

Every argument is Snakemake's. What a killed run left is cleared by the workflow itself.
"""

from __future__ import annotations

import runpy
import signal
import sys

# Ctrl-C is for one thread, see `ends_at_interrupt`; those that numpy starts inherit this.
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})

from mocap_workflow import runs  # noqa: E402

if __name__ == "__main__":
    runs.ends_at_interrupt()
    sys.argv[0] = "snakemake"
    try:
        runpy.run_module("snakemake", run_name="__main__")  # as `python -m snakemake`
    except KeyboardInterrupt:  # before jobs are started; then Snakemake itself ends
        print("Interrupted", file=sys.stderr)
    finally:
        runs.ends_as_interrupted()
