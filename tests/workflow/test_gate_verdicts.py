"""The last lines of a run: words of its recordings, if not too many, and where to look."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from running import environment

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
    input=given, output=["gate.json"], log=["gate.log"], config={{"results": "recordings"}}
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
