"""A refused recording spoils no table and is named last; mended, only its own branch runs."""

import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
from running import environment, finished

OF_SNAKEMAKE = (  # what a person has no use for
    *("RuleException", "CalledProcessError", "WorkflowError", ".snakemake/scripts", "Level 25"),
    *("Removing temporary output", "Updating checkpoint", "Error in rule", "Traceback"),
)


def test_refusal_rerun_mending_and_a_new_row(root: Path, toy: Path, snakemake) -> None:
    """First as `make` runs it, with the project's own profile: refusals are said once and last,
    behind what is said of the others."""
    (toy / "config/b.c3d").write_text("b is bad\n")
    (toy / "config/c.c3d").write_text("c moves\n")
    old = toy / "results/recordings/b/noise.csv"
    old.parent.mkdir(parents=True)
    old.write_text("from an earlier run\n")

    first = subprocess.run(
        [sys.executable, str(root / "workflow/run.py"), "--cores", "2", "--retries", "1"],
        cwd=toy,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=900,
    )
    assert first.returncode == 1, first.stdout
    lines = [line for line in first.stdout.splitlines() if "jobs done (" not in line]  # progress
    assert lines[-2:] == ["warning: recording c: marker A moves", "recording b refused: it is bad"]
    assert first.stdout.count("it is bad") == 1
    assert not [words for words in OF_SNAKEMAKE if words in first.stdout]
    assert "Level 25" not in (toy / "results/logs/gate/all.log").read_text()
    ran = Counter(path.parent.name for path in (toy / "results/benchmarks").glob("*/*.tsv"))
    assert ran == {"clean": 4, "noise": 3, "group_table": 3}  # of b, too: a refusal is no failure
    tables = toy / "results/tables"
    assert (tables / "g_noise.csv").read_text() == "a is good\n"
    assert (tables / "h_noise.csv").read_text() == "c moves\n"
    assert (tables / "t_noise.csv").read_text() == "T\n"
    assert not old.exists()

    (toy / "config/b.c3d").write_text("b is mended\n")
    with (toy / "config/recordings.tsv").open("a") as stream:
        stream.write("u\tsimulate:T\t\tt\n")
    mended = snakemake(toy, "--cores", "2")
    assert mended.returncode == 0, mended.stdout
    assert finished(mended.stdout) == {
        "clean": 1,  # b
        "clean_twin": 1,  # u
        "noise": 2,
        "group_table": 2,  # g and t, not h
        "gate": 1,
        "default": 1,
    }
    assert (tables / "g_noise.csv").read_text() == "a is good\nb is mended\n"
    assert (tables / "t_noise.csv").read_text() == "T\nT\n"


GATE = Path(__file__).resolve().parents[2] / "workflow/scripts/gate.py"
RUN = """
import runpy, sys
from pathlib import Path
from types import SimpleNamespace
sys.path.insert(0, {folder!r})
results = [*map(str, sorted(Path().glob("recordings/*/*.json")))]
results += map(str, Path().glob("out/summary.html"))
class Given(list):
    checks = []

given = Given(results)
given.results = results
snakemake = SimpleNamespace(
    input=given, output=["gate.json"], log=["recordings/logs/gate.log"],
    config={{"results": "recordings"}},
)
runpy.run_path({gate!r}, init_globals={{"snakemake": snakemake}})
"""


@pytest.mark.parametrize("count", [2, 11])
def test_words_on_the_terminal(tmp_path: Path, count: int) -> None:
    for k in range(count):
        own = tmp_path / f"recordings/take-{k:02d}"
        own.mkdir(parents=True)
        (own / "verdict.json").write_text(json.dumps({"word": "good", "reason": f"{k} mm."}) + "\n")
        (own / "diagnosis.json").write_text(json.dumps({"findings": [], "sentences": []}) + "\n")
    if count != 2:  # as for a target without it
        (tmp_path / "out").mkdir()
        (tmp_path / "out/summary.html").touch()
    code = RUN.format(folder=str(GATE.parent), gate=str(GATE))
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    lines = [f"recording take-{k:02d} is good: {k} mm." for k in range(count)]
    lines = lines if count <= 10 else []
    assert done.stderr.splitlines() == lines + ["see out/summary.html"] * (count != 2)
    assert (tmp_path / "gate.json").is_file()
