"""A process with all modules and kernels loaded, which forks one for each job of a run.

To import them takes a job a second or two, most of a short one. A job's own process hands its
script over and waits: it ends as the fork does, and the fork ends when it is killed. Where no fork
begins (the first jobs of a run, other hosts), a job does its work itself.
"""

from __future__ import annotations

import atexit
import contextlib
import gc
import importlib
import json
import os
import runpy
import secrets
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import traceback
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

ADDRESS = "MOCAP_METROLOGY_FORKS"  # in the environment of jobs
LEAST_JOBS = 8  # of a run, from which it pays
LONGEST = 107  # bytes of the path of a socket
USED = (  # beside what modules import when they are: first one thread
    *("step", "pyarrow.parquet", "scipy.ndimage", "scipy.optimize"),
    *("scipy.signal", "scipy.spatial.transform", "scipy.stats"),
)


def serve(n_jobs: int) -> None:
    """Start the process for the jobs of this one; it ends with this one."""
    if n_jobs >= LEAST_JOBS and sys.platform == "linux":
        address = f"{tempfile.gettempdir()}/mocap-metrology-{secrets.token_hex(8)}/socket"
        if len(os.fsencode(address)) > LONGEST:
            return
        place = Path(__file__).parents[1]
        paths = os.pathsep.join(map(str, (place, place / "scripts", *sys.path)))
        command = [sys.executable, "-m", "mocap_workflow.forks", address]
        environment = os.environ | {"PYTHONPATH": paths}
        server = subprocess.Popen(command, stdin=subprocess.PIPE, env=environment)
        os.environ[ADDRESS] = address
        atexit.register(server.wait)
        atexit.register(server.terminate)


def refuse() -> None:
    """Have the scripts that this process starts do their work themselves."""
    os.environ.pop(ADDRESS, None)


def hand_over(address: str) -> None:
    """Have a fork run the script of this process and end as it does; returns where none can."""
    link, begun = socket.socket(socket.AF_UNIX), b""
    with contextlib.suppress(OSError):
        send_request(link, address, sys.argv[0], Path.cwd(), os.environ)
        begun = link.recv(1)
    if begun:
        if status := link.recv(1):
            os._exit(status[0])
        os.kill(os.getpid(), signal.SIGKILL)  # as the fork was, so that the run names this reason


def send_request(
    link: socket.socket,
    address: str,
    what: Any,
    folder: Path,
    environment: Mapping[str, str],
    files: Sequence[int] = (0, 1, 2),
) -> None:
    """Have a fork do `what`, in this folder and environment and with these standard files."""
    told = json.dumps([what, str(folder), dict(environment)]).encode()
    link.connect(address)
    socket.send_fds(link, [len(told).to_bytes(4)], files)
    link.sendall(told)


def receive_request(link: socket.socket) -> Any:
    """What `send_request` asks for; this process then has its folder, environment and standard
    files."""
    size, files, *_ = socket.recv_fds(link, 4, 3)
    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    what, folder, environment = json.loads(link.recv(int.from_bytes(size), socket.MSG_WAITALL))
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    return what


def main(address: str) -> None:
    """Load everything, then fork until the run ends, which closes the standard input."""
    atexit.register(shutil.rmtree, Path(address).parent, ignore_errors=True)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # the run hears Ctrl-C, and ends this
    for name in USED:
        importlib.import_module(name)
    from mocap_metrology.common import compiled
    from mocap_metrology.present.plot.figure import import_matplotlib

    compiled.warm()  # which imports every module
    import_matplotlib()
    Path(address).parent.mkdir(mode=0o700)  # of this user alone
    process = os.getpid()
    try:
        if link := fork_for_each(address):
            _work(link)
    finally:
        if os.getpid() != process:
            os._exit(1)  # and nothing of what ends the process that forked


def fork_for_each(address: str) -> socket.socket | None:
    """In a fork for each process that asks at the address: the link to it. In this process, when
    its standard input ends: None."""
    gc.freeze()
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(address)
        listener.listen(64)
        while sys.stdin not in (ready := select.select([listener, sys.stdin], [], [], 1.0)[0]):
            if ready:
                link, _ = listener.accept()
                if os.fork() == 0:
                    return link
                link.close()
            _reap()
    return None


def _reap() -> None:
    """Clear forks that have ended, whose time then counts as this process's."""
    with contextlib.suppress(ChildProcessError):  # there is none
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


def _work(link: socket.socket) -> None:
    """Run the script that is told of through the link, as in its own process."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    script = receive_request(link)
    threading.Thread(target=_ends_with, args=[link], daemon=True).start()
    link.send(b"b")  # begun
    sys.argv, status = [script], 0
    try:
        runpy.run_path(script, run_name="__main__")
    except SystemExit as ended:
        status = ended.code if isinstance(ended.code, int) else int(ended.code is not None)
        if status and not isinstance(ended.code, int):
            print(ended.code, file=sys.stderr)
    except BaseException:
        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    sys.stderr.flush()
    link.send(bytes([status & 255]))
    os._exit(status & 255)


def _ends_with(link: socket.socket) -> None:
    """End this process when the job's own has ended, be it before it read that this one began."""
    with contextlib.suppress(OSError):
        link.recv(1)
    os._exit(1)


if __name__ == "__main__":
    main(sys.argv[1])
