"""Snakemake in forks of a process that has loaded it, which takes most of the time of a dry run."""

import importlib
import os
import runpy
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

# By itself, as Snakemake is to import the package of the workflow that it runs.
sys.path.insert(0, str(Path(__file__).parents[2] / "workflow/mocap_workflow"))
import forks

sys.path.pop(0)

LOADED = ("numba", "pandas", "psutil", "pyarrow.parquet", "snakemake.cli", "sqlmodel")


@contextmanager
def loaded(folder: Path) -> Iterator[str]:
    """Address of such a process, which ends with its standard input."""
    address = folder / "socket"
    with subprocess.Popen([sys.executable, __file__, address], stdin=subprocess.PIPE) as server:
        while not address.exists():
            assert server.poll() is None
            time.sleep(0.05)
        yield str(address)
        server.communicate()


def run(
    address: str, folder: Path, arguments: tuple[str, ...], environment: dict[str, str]
) -> subprocess.CompletedProcess[str]:
    """As `python -m snakemake` in a folder with this environment; both outputs as `stdout`."""
    reading, writing = os.pipe()
    with (
        socket.socket(socket.AF_UNIX) as link,
        os.fdopen(reading, encoding="utf-8") as stream,
        Path(os.devnull).open() as nothing,
    ):
        files = nothing.fileno(), writing, writing
        forks.send_request(link, address, arguments, folder, environment, files)
        os.close(writing)
        said = stream.read()
        return subprocess.CompletedProcess(arguments, int(link.recv(9)), said)


def work(link: socket.socket) -> None:
    """In a fork: another one runs Snakemake, whose status this one hands back."""
    arguments = forks.receive_request(link)
    if pid := os.fork():
        os.closerange(0, 3)
        link.send(str(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])).encode())
        os._exit(0)
    paths = os.environ.get("PYTHONPATH")
    sys.path[:1] = [str(Path.cwd()), *(paths.split(os.pathsep) if paths else [])]
    sys.argv = ["snakemake", *arguments]
    runpy.run_module("snakemake", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    for name in LOADED:
        importlib.import_module(name)
    if link := forks.fork_for_each(sys.argv[1]):
        work(link)
