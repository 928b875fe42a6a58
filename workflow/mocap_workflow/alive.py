"""One run at a time in a folder, and none kept out by a run that was killed.

Snakemake's locks are files, so they outlive a killed run and refuse the next. The lock here is
the kernel's and dies with its process: who holds it knows that lock files present are stale.
"""

from __future__ import annotations

import contextlib
import fcntl
import io
import os
from collections.abc import Sequence
from pathlib import Path

from mocap_workflow.faults import Faults

# Modes in which Snakemake runs no job; the list follows the branches of its command line.
# fmt: off
IDLE = (
    "dryrun", "lint", "unlock", "list_target_rules", "list_rules", "print_compilation",
    "containerize", "dag", "rulegraph", "filegraph", "d3dag", "generate_unit_tests",
    "cleanup_metadata", "list_conda_envs", "cleanup_shadow", "list_changes",
    "list_input_changes", "list_params_changes", "list_untracked", "summary",
    "detailed_summary", "archive", "report", "deploy_sources", "conda_cleanup_envs",
    "conda_create_envs_only",
)
# fmt: on

_held: list[int] = []  # open as long as the process lives


def runs_jobs(argv: Sequence[str]) -> bool:
    """Whether this command line is of a main process that will run jobs."""
    from snakemake.cli import parse_args

    if Path(argv[0]).name not in ("snakemake", "__main__.py"):
        return False
    with contextlib.redirect_stderr(io.StringIO()):  # it would name the profiles once more
        options = vars(parse_args(list(argv[1:]))[1])
    after = options.get("report_after_run")
    idle = [mode for mode in IDLE if not (mode == "report" and after)]
    started = str(options.get("mode")).rpartition(".")[2].lower()
    return started == "default" and not any(options.get(mode) for mode in idle)


def take(folder: Path) -> bool:
    """Hold the folder for this process and clear stale locks; `Faults` when another holds it.

    False where nothing can be locked: Snakemake's own locks are all there is then.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder / "alive", os.O_RDWR | os.O_CREAT, 0o666)  # not passed on to jobs
    except OSError:  # Snakemake will say what is wrong with the folder
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        holder = os.read(handle, 100).decode(errors="replace").strip() or "unknown"
        os.close(handle)
        raise Faults(
            [f"{folder.parent.resolve()}: another run works here (process {holder}); expected none"]
        ) from None
    except OSError:
        os.close(handle)
        return False
    os.truncate(handle, 0)
    os.write(handle, f"{os.getpid()}\n".encode())
    _held.append(handle)
    for lock in folder.glob("locks/*.lock"):
        lock.unlink(missing_ok=True)
    return True
