"""What a script's failure looks like: one line on the terminal, everything in the log."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).resolve().parents[2] / "workflow/scripts"
SCRIPT = """
import os, sys
from types import SimpleNamespace
sys.path.insert(0, {scripts!r})
from step import step
from mocap_metrology.common.errors import Refusal
snakemake = SimpleNamespace(log=["results/logs/a.log"], rule="clean", input=[],
    wildcards={{"recording": "T40"}}, config={{"results": "results"}})
with step(snakemake) as log:
    log.info("at work")
    print("a word")
    os.write(2, b"from C\\n")
    {body}
print("after")
"""


def run(folder: Path, body: str) -> tuple[int, str, str]:
    script = SCRIPT.format(scripts=str(SCRIPTS), body=body)
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    return done.returncode, done.stdout, (folder / "results/logs/a.log").read_text()


def test_work_that_succeeds_speaks_to_its_log(tmp_path: Path) -> None:
    """And its cost: a thread that waits takes time, and a list memory."""
    body = "print(os.environ['OPENBLAS_NUM_THREADS']); [0] * 10**7; os.system('sleep 0.5')"
    status, terminal, log = run(tmp_path, body)
    assert (status, terminal) == (0, "after\n")
    assert all(text in log for text in ("INFO at work", "a word", "from C", "1\n"))
    keys, values = (tmp_path / "results/benchmarks/a.tsv").read_text().splitlines()
    cost = dict(zip(keys.split("\t"), map(float, values.split("\t")), strict=True))
    assert 0.5 <= cost["s"] < 5.0 and 32 < cost["max_rss"] < 1000 and 0 < cost["cpu_time"] < 5.0


@pytest.mark.parametrize(
    ("body", "status", "line"),
    [
        ("raise Refusal('x.c3d: short;\\n expected 10 frames')",
         1, "clean T40: x.c3d: short; expected 10 frames\n"),
        ("1 / 0", 1, "clean T40: ZeroDivisionError: division by zero (see results/logs/a.log)\n"),
        ("open('/dev/full', 'w').write('x' * 10**6)", 1,
         "clean T40: results: No space left on device; free some there, then run again\n"),
        ("log.warning('marker A moves')", 0, "warning: clean T40: marker A moves\nafter\n"),
        ("sys.exit(3)", 3, ""),
    ],
)  # fmt: skip
def test_the_terminal_gets_one_line(tmp_path: Path, body: str, status: int, line: str) -> None:
    found, terminal, log = run(tmp_path, body)
    assert (found, terminal) == (status, line)
    assert ("Traceback" in log) == ("1 / 0" in body)
    assert "Refusal" not in log
