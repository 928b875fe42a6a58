"""The workflow in another folder, from another checkout, and in another workflow."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from running import command, environment, planned

ROOT = Path(__file__).resolve().parents[2]
SHEET = "recording\tpath\tmarkers\tgroup\nwrong\twrong.c3d\tA;B\tlab\n"
HOST = """
configfile: "{root}/config/config.yaml"


config |= {{"results": "{results}", "recordings": "{sheet}", "calibrations": None}}


module mocap:
    snakefile:
        "{root}/workflow/Snakefile"
    config:
        config


use rule * from mocap as mocap_*


rule all:
    default_target: True
    input:
        "own.txt",
        "{results}/{target}",


rule own:
    output:
        "own.txt",
    shell:
        "touch {{output}}"
"""


def host_of(target: str, root: Path = ROOT, results: str = "mocap", sheet="sheet.tsv") -> str:
    """Snakefile of a workflow that uses this one, for one of its results."""
    return HOST.format(root=root, results=results, sheet=sheet, target=target)


def folder_with_sheet(folder: Path) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "wrong.c3d").write_text("no recording\n")
    (folder / "sheet.tsv").write_text(SHEET)
    return folder


def test_as_a_module_of_another_workflow(tmp_path: Path, snakemake) -> None:
    folder_with_sheet(tmp_path)
    (tmp_path / "profiles").symlink_to(ROOT / "profiles")
    (tmp_path / "Snakefile").write_text(host_of("gate/recordings.json"))
    done = snakemake(tmp_path, "--cores", "1")
    assert "recording wrong refused: wrong.c3d: is not a C3D file" in done.stdout
    assert (tmp_path / "own.txt").is_file()
    assert (tmp_path / "mocap/recordings/wrong/check.json").is_file()


def test_the_plan_of_a_recording_that_was_not_checked_yet(tmp_path: Path, snakemake) -> None:
    folder_with_sheet(tmp_path)
    settings = ("--config", "recordings=sheet.tsv", "calibrations=")
    named = ("results/recordings/wrong/verdict.json", "--directory", str(tmp_path), *settings)
    plan = snakemake(ROOT, "-n", *named)
    assert planned(plan.stdout) == dict.fromkeys(("clean", "noise", "verdict"), 1), plan.stdout


def test_the_environment_of_a_checkout_that_differs_is_refused(tmp_path: Path) -> None:
    ignored = shutil.ignore_patterns("__pycache__", ".*")
    for name in ("workflow", "src", "config", "profiles", "requirements"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=ignored)
    shutil.copy(ROOT / "Snakefile", tmp_path)
    (tmp_path / "src/mocap_metrology/io/__init__.py").write_text("# another state\n")
    done = subprocess.run(
        command("-n"), cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=900
    )
    assert done.returncode == 1
    line = done.stderr.splitlines()[-1]
    assert line.startswith("mocap_metrology is imported from ")
    assert f"expected {tmp_path}/src/mocap_metrology: run `make env` here" in line
