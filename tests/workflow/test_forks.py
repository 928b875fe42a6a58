"""Scripts of jobs in forks: they end as in a process of their own, and with it."""

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from mocap_workflow import forks

WORKFLOW = Path(__file__).resolve().parents[2] / "workflow"
SCRIPT = """
import os, sys
sys.path.extend([{scripts!r}, {workflow!r}])
from step import step
loaded = "mocap_metrology.recording.figures" in sys.modules
print(loaded, os.getpid(), os.environ["OWN"], os.environ["OPENBLAS_NUM_THREADS"], flush=True)
{body}
"""
PATIENCE_S = 120.0


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """Of a process that forks, which ends when its input does."""
    folder = tmp_path_factory.mktemp("forks") / "own"
    command = [sys.executable, "-m", "mocap_workflow.forks", str(folder / "socket")]
    paths = os.pathsep.join(map(str, (WORKFLOW, WORKFLOW / "scripts")))
    environment = os.environ | {"PYTHONPATH": paths}
    with subprocess.Popen(command, stdin=subprocess.PIPE, env=environment) as server:
        begun = time.monotonic()
        while not (folder / "socket").exists():
            assert server.poll() is None and time.monotonic() - begun < PATIENCE_S
            time.sleep(0.1)
        yield str(folder / "socket")
        server.terminate()  # as when a run is interrupted; else its input ends
        assert server.wait(10) == 0
    assert not folder.exists()


def start(folder: Path, address: str, body: str) -> subprocess.Popen:
    script = folder / "script.py"
    script.write_text(
        SCRIPT.format(scripts=str(WORKFLOW / "scripts"), workflow=str(WORKFLOW), body=body)
    )
    environment = os.environ | {"MOCAP_METROLOGY_FORKS": address, "OWN": "of the job"}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(
        [sys.executable, script], cwd=folder, env=environment, text=True, **pipes
    )


@pytest.mark.parametrize(
    ("body", "status", "told"),
    [("open('here', 'w').close()", 0, ""), ("sys.exit(3)", 3, ""), ("sys.exit(-1)", 255, ""),
     ("sys.exit('why')", 1, "why"), ("1 / 0", 1, "ZeroDivisionError"),
     ("os.kill(os.getpid(), 9)", -9, ""),
     ("import subprocess; sys.exit(subprocess.call(['false']))", 1, "")],
)  # fmt: skip
def test_a_script_ends_as_in_its_own_process(tmp_path, address, body, status, told) -> None:
    job = start(tmp_path, address, body)
    words, errors = job.communicate(timeout=60)
    loaded, pid, *rest = words.split(maxsplit=2)
    assert loaded == "True" and int(pid) != job.pid and rest == ["of the job 1\n"]
    assert job.returncode == status and told in errors
    assert (tmp_path / "here").exists() == ("here" in body)


@pytest.mark.parametrize("answers", [False, True])
def test_without_a_fork_a_script_runs_in_its_own_process(tmp_path, answers) -> None:
    with socket.socket(socket.AF_UNIX) as listener:  # as of a process that is killed
        listener.bind(str(tmp_path / "socket"))
        if answers:
            listener.listen()
        job = start(tmp_path, str(tmp_path / "socket"), "")
        if answers:
            listener.accept()[0].close()
        loaded, pid, _ = job.communicate(timeout=60)[0].split(maxsplit=2)
    assert (loaded, int(pid), job.returncode) == ("False", job.pid, 0)


@pytest.mark.parametrize("read", [True, False])
def test_a_fork_ends_with_its_job(tmp_path, address, read) -> None:
    """Also one that is killed before it has read that its fork began: the link is then reset."""
    script = tmp_path / "script.py"
    script.write_text("import os, time; print(os.getpid(), flush=True); time.sleep(600)")
    output, words = os.pipe()
    with socket.socket(socket.AF_UNIX) as link:
        forks.send_request(link, address, str(script), tmp_path, os.environ, (0, words, 2))
        fork = psutil.Process(int(os.read(output, 20)))
        if read:
            assert link.recv(1) == b"b"
    fork.wait(PATIENCE_S)
    os.close(output)
    os.close(words)


def test_a_fork_ends_with_the_process_of_its_job(tmp_path, address) -> None:
    job = start(tmp_path, address, "import time; time.sleep(600)")
    fork = psutil.Process(int(job.stdout.readline().split()[1]))
    job.send_signal(signal.SIGKILL)
    fork.wait(PATIENCE_S)
    assert not fork.is_running() and job.wait(PATIENCE_S) == -signal.SIGKILL
    job.communicate()
