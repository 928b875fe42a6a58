"""The same answer everywhere: whatever the processors, order of rows, time zone, locale, folder
and checkout, the results are the same bytes.

`make test-everywhere` compares every result of small_run.py, and first those of some steps.
"""

import shutil
import subprocess
from pathlib import Path

import pytest
import small_run
from running import command, environment, side_by_side

HERE = {"TZ": "UTC", "LC_ALL": "C.UTF-8", "PYTHONHASHSEED": "0"}
ELSEWHERE = {"TZ": "Asia/Kathmandu", "PYTHONHASHSEED": "1"}


def another_locale() -> str:
    """One of this system that is not that of `HERE`, with a decimal comma if there is any."""
    known = subprocess.run(["locale", "-a"], capture_output=True, text=True, check=True).stdout
    return max(known.split(), key=lambda name: (name.startswith(("de_", "fr_")), name == "POSIX"))


def copied(folder: Path) -> Path:
    """The files of the project in another folder, as a clone has them."""
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=small_run.ROOT, capture_output=True, check=True
    )
    for name in filter(None, listed.stdout.decode().split("\0")):
        if (small_run.ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(small_run.ROOT / name, folder / name)
    return folder


def reverse_rows(folder: Path) -> None:
    for sheet in folder.glob("*.tsv"):
        header, *rows = sheet.read_text(encoding="utf-8").splitlines()
        sheet.write_text("\n".join([header, *reversed(rows)]) + "\n", encoding="utf-8")


def run(root: Path, folder: Path, cores: int, variables: dict[str, str], *targets: str) -> Path:
    """Run the workflow of a checkout in a folder; returns that of the results."""
    profile = ("--workflow-profile", str(root / "profiles/ci"))
    done = subprocess.run(
        [*command()[:3], *profile, "--cores", str(cores), *targets, *small_run.arguments(root)],
        **{"cwd": folder, "env": environment() | {"PYTHONPATH": str(root / "src")} | variables},
        **{"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT},
        text=True,
    )
    assert done.returncode == 0, done.stdout
    return folder / "results"


def compare(tmp_path: Path, *targets: str) -> list[str]:
    here = small_run.write_inputs(tmp_path / "here")
    there = small_run.write_inputs(tmp_path / "another folder, ß")
    reverse_rows(there)
    clone = copied(tmp_path / "clone")
    elsewhere = ELSEWHERE | {"LC_ALL": another_locale()}
    one, other = side_by_side(
        lambda: run(small_run.ROOT, here, 1, HERE, *targets),
        lambda: run(clone, there, 2, elsewhere, *targets),
    )
    return small_run.differences(one, other)


@pytest.mark.everywhere
def test_every_result(tmp_path: Path) -> None:
    assert compare(tmp_path) == []
