"""What a changed cell of a sheet, source or file of the package computes anew, and nothing else."""

import functools
import json
import shutil
import subprocess
from pathlib import Path
from types import SimpleNamespace

import forked
import pytest
from running import command, environment, pass_for_computed, planned, side_by_side, write_sheet

ROOT = Path(__file__).resolve().parents[2]
HEADER = ["recording", "path", "markers", "group", "date", "comment"]
RECORDINGS = [
    {"recording": "measured", "markers": "A;B;C", "group": "lab"},
    {"recording": "simulated", "path": "simulate:walk-and-white", "group": "lab"},
]
CALIBRATIONS = [
    {"calibration": "sim-1-1", "setup": "sim-1", "group": "jansen2019"}
    | {"path": "simulate:sim-1-1", "format": "gpio-dump"}
]
LAST = {"pages", "provenance", "gate", "default"}
# What depends on the results of a module
OF_ROTORS = {
    *("calibration_twins_1", "calibration_figures", "calibration_tables", "claims", "jansen")
}


def sheets(folder: Path, file: Path, changed: dict[str, dict[str, str]]) -> list[str]:
    """Write both sheets with these cells, by recording or calibration; what `--config` has to say.

    Their names are always the same, as the page of provenance has them.
    """
    folder.mkdir(exist_ok=True)
    settings = []
    for name, header, rows in (
        ("recordings", HEADER, [row | {"path": row.get("path", str(file))} for row in RECORDINGS]),
        ("calibrations", [*CALIBRATIONS[0], "comment"], CALIBRATIONS),
    ):
        rows = [row | changed.get(next(iter(row.values())), {}) for row in rows]
        written = folder / write_sheet(folder, header, *rows)
        settings.append(f"{name}={written.rename(folder / f'{name}.tsv')}")
    return settings


@pytest.fixture(scope="module")
def computed(tmp_path_factory, loaded: str) -> SimpleNamespace:
    """A copy of the project in which everything passes for computed, without a number in it."""
    folder = tmp_path_factory.mktemp("computed")
    ignored = shutil.ignore_patterns("__pycache__", ".*")
    for name in ("workflow", "src", "config", "profiles", "requirements"):
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    shutil.copy(ROOT / "Snakefile", folder)
    file = folder / "given.c3d"
    file.touch()
    check = folder / "results/recordings/measured/check.json"
    check.parent.mkdir(parents=True)
    check.write_text(json.dumps({"ok": True, "why": "", "warnings": [], "notes": []}) + "\n")
    settings = sheets(folder / "sheets", file, {})
    own = environment() | {"PYTHONPATH": str(folder / "src")}
    results = f"results={folder}/results"

    def run(*arguments: str) -> subprocess.CompletedProcess:
        """Snakemake in the copy, with its package."""
        return forked.run(loaded, folder, command(*arguments)[3:], own)

    pass_for_computed(run, "--config", *settings, results)
    return SimpleNamespace(folder=folder, run=run, results=results)


def plan(computed: SimpleNamespace, name: str = "sheets", changed: dict | None = None) -> set[str]:
    """Rules that would run with these cells."""
    given = sheets(computed.folder / name, computed.folder / "given.c3d", changed or {})
    output = computed.run("-n", "--config", *given, computed.results).stdout
    return set(planned(output)) - LAST


def test_an_edit_runs_again_what_imports_the_file(computed: SimpleNamespace) -> None:
    file = computed.folder / "src/mocap_metrology/lighthouse/rotor.py"
    before = file.read_text(encoding="utf-8")
    file.write_text(f"{before}# a word\n", encoding="utf-8")
    try:
        assert plan(computed) == OF_ROTORS
    finally:
        file.write_text(before, encoding="utf-8")


def test_a_changed_cell_computes_anew_what_reads_its_column(computed: SimpleNamespace) -> None:
    changes = {
        "words": {
            "measured": {"date": "2024-05-01"},
            "simulated": {"comment": "to be left out"},
            "sim-1-1": {"comment": "moved"},
        },
        "group": {"simulated": {"group": "hall"}},
    }
    expected = {
        "words": {"group_tables"},  # which has a column of comments
        "group": {"verdict", "group_tables", "noise_tables"},
    }

    plans = (functools.partial(plan, computed, name, changes[name]) for name in changes)
    assert dict(zip(expected, side_by_side(*plans), strict=True)) == expected
