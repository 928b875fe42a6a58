"""The workflow on a SLURM cluster of two nodes, of which one is lost: the results of a local run.

`make test-cluster` runs this in namespaces of its own, see run.sh.
"""

import os
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import small_run
from running import command, environment

pytestmark = pytest.mark.cluster
NODES = ("n1", "n2")
HOUR_S = 3600.0


def said(*words: str) -> str:
    """What a program prints; nothing where there is no controller to ask yet."""
    return subprocess.run(words, stdout=subprocess.PIPE, text=True, check=False).stdout


def wait_for(what: str, found: Callable[[], object], patience_s: float = 60.0) -> None:
    """Until `found` returns something true."""
    end = time.monotonic() + patience_s
    while not found():
        assert time.monotonic() < end, f"no {what} within {patience_s:g} s"
        time.sleep(0.5)


@pytest.fixture
def cluster() -> Iterator[dict[str, subprocess.Popen]]:
    """A controller and its nodes, by name. Each node is a process table: with its first process
    everything on it ends, as when a machine loses its power."""
    folder = Path(os.environ["MOCAP_SLURM"])
    for name in ("state", *(f"spool.{node}" for node in NODES)):
        (folder / name).mkdir(mode=0o755)
    key = folder / "munge.key"
    key.write_bytes(os.urandom(128))
    key.chmod(0o600)
    template = (Path(__file__).parent / "slurm.conf").read_text(encoding="utf-8")
    filled = template.replace("{folder}", str(folder)).replace("{host}", socket.gethostname())
    Path("/etc/slurm/slurm.conf").write_text(filled, encoding="utf-8")
    munge = {"key": key, "socket": folder / "munge.socket", "pid": folder / "munge.pid"}
    munge |= {"log": folder / "munge.log", "seed": folder / "munge.seed"}
    files = [f"--{name}{'' if name == 'socket' else '-file'}={p}" for name, p in munge.items()]
    daemons = [subprocess.Popen(["munged", "--foreground", *files])]
    wait_for("MUNGE", munge["socket"].exists)
    daemons.append(subprocess.Popen(["slurmctld", "-D"], stderr=subprocess.DEVNULL))
    space = ["unshare", "--pid", "--uts", "--fork", "--kill-child", "--mount-proc", "sh", "-c"]
    nodes = {
        node: subprocess.Popen(
            [*space, f"hostname {node}; slurmd -D -N {node}; wait"], stderr=subprocess.DEVNULL
        )
        for node in NODES
    }
    try:
        states = ("sinfo", "-h", "-N", "-o", "%t")
        wait_for("idle nodes", lambda: said(*states).split() == ["idle"] * len(NODES))
        yield nodes
    finally:
        for daemon in (*nodes.values(), *reversed(daemons)):
            daemon.kill()
            daemon.wait()


def jobs(*states: str) -> list[str]:
    """Numbers of the jobs in these states, of all nodes."""
    return said("squeue", "-h", "-o", "%A", "-t", ",".join(states)).split()


def on(node: str) -> list[str]:
    """Numbers of the jobs that run on a node."""
    return said("squeue", "-h", "-o", "%A", "-t", "R", "-w", node).split()


def run(folder: Path, profile: str, *more: str) -> subprocess.Popen:
    """Snakemake in a folder, with a profile of the project; its lines go to `out` there."""
    words = [*command()[:3], "--workflow-profile", str(small_run.ROOT / "profiles" / profile)]
    with (folder / "out").open("w") as out:
        return subprocess.Popen(
            [*words, *more, *small_run.arguments()],
            **{"cwd": folder, "env": environment(), "stdin": subprocess.DEVNULL},
            **{"stdout": out, "stderr": subprocess.STDOUT},
        )


def test_with_a_node_lost_the_results_are_those_of_a_local_run(
    tmp_path: Path, cluster: dict[str, subprocess.Popen]
) -> None:
    local = small_run.write_inputs(tmp_path / "local")
    spread = small_run.write_inputs(tmp_path / "spread")
    assert run(local, "ci", "--cores", "2").wait(HOUR_S) == 0, (local / "out").read_text()

    # This cluster has no accounting, and no file server that is slow to show new files
    own = ("--slurm-status-command", "squeue", "--latency-wait", "5")
    snakemake = run(spread, "slurm", *own)
    wait_for("finished job while n1 works", lambda: jobs("CD") and on("n1"), HOUR_S)
    cluster["n1"].kill()
    assert snakemake.wait(HOUR_S) == 0, (spread / "out").read_text()

    assert said("sinfo", "-h", "-n", "n1", "-o", "%t").startswith("down")
    assert jobs("PD", "R") == []
    assert small_run.differences(local / "results", spread / "results") == []
