"""The workflow in another folder, from another checkout, and in another workflow."""

from pathlib import Path

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
