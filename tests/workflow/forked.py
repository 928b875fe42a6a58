"""Snakemake in forks of a process that has loaded it, which takes most of the time of a dry run."""

from __future__ import annotations

import gc
import importlib
import json
import os
import runpy
import select
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

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
    told = json.dumps([str(folder), arguments, environment]).encode()
    reading, writing = os.pipe()
    with socket.socket(socket.AF_UNIX) as link, os.fdopen(reading, encoding="utf-8") as stream:
        link.connect(address)
        socket.send_fds(link, [len(told).to_bytes(4)], [writing])
        os.close(writing)
        link.sendall(told)
        said = stream.read()
        return subprocess.CompletedProcess(arguments, int(link.recv(9)), said)


def work(link: socket.socket) -> None:
    """In a fork: another one runs Snakemake, whose status this one hands back."""
    size, (output,), *_ = socket.recv_fds(link, 4, 1)
    told = link.recv(int.from_bytes(size), socket.MSG_WAITALL)
    folder, arguments, environment = json.loads(told)
    if pid := os.fork():
        os.close(output)
        link.send(str(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])).encode())
        os._exit(0)
    for number, file in enumerate((os.open(os.devnull, os.O_RDONLY), output, output)):
        os.dup2(file, number)
    os.close(output)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    paths = environment.get("PYTHONPATH")
    sys.path[:1] = [folder, *(paths.split(os.pathsep) if paths else [])]
    sys.argv = ["snakemake", *arguments]
    runpy.run_module("snakemake", run_name="__main__", alter_sys=True)


def main(address: str) -> None:
    for name in LOADED:
        importlib.import_module(name)
    gc.freeze()
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(address)
        listener.listen()
        while sys.stdin not in select.select([listener, sys.stdin], [], [])[0]:
            link, _ = listener.accept()
            if os.fork() == 0:
                listener.close()
                return work(link)
            link.close()
    with suppress(ChildProcessError):  # whose time then counts as this process's
        while os.wait():
            pass
    return None


if __name__ == "__main__":
    main(sys.argv[1])
