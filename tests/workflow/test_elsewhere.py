"""The workflow as a module of another workflow."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SHEET = "recording\tpath\tmarkers\tgroup\nwrong\twrong.c3d\tA;B\tlab\n"
HOST = """
configfile: "ROOT/config/config.yaml"


config |= {"results": "mocap", "recordings": "sheet.tsv", "calibrations": None}


module mocap:
    snakefile:
        "ROOT/workflow/Snakefile"
    config:
        config


use rule * from mocap as mocap_*


rule all:
    default_target: True
    input:
        "own.txt",
        "mocap/gate/recordings.json",


rule own:
    output:
        "own.txt",
    shell:
        "touch {output}"
"""


def test_as_a_module_of_another_workflow(tmp_path: Path, snakemake) -> None:
    (tmp_path / "wrong.c3d").write_text("no recording\n")
    (tmp_path / "sheet.tsv").write_text(SHEET)
    (tmp_path / "profiles").symlink_to(ROOT / "profiles")
    (tmp_path / "Snakefile").write_text(HOST.replace("ROOT", str(ROOT)))
    done = snakemake(tmp_path, "--cores", "1")
    assert "recording wrong refused: wrong.c3d: is not a C3D file" in done.stdout
    assert (tmp_path / "own.txt").is_file()
    assert (tmp_path / "mocap/recordings/wrong/check.json").is_file()
    asked = snakemake(tmp_path, "--cores", "1", "mocap/recordings/wrong/verdict.json").stdout
    assert "wrong was refused: wrong.c3d: is not a C3D file" in asked and "crashed" not in asked
