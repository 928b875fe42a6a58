"""What a changed cell of a sheet computes anew: what reads its column, and nothing else."""

from __future__ import annotations

import functools
import json
import os
from pathlib import Path

import pytest
from running import pass_for_computed, planned, side_by_side, write_sheet

HEADER = ["recording", "path", "markers", "pairs", "group", "date", "comment"]
RECORDINGS = [
    {"recording": "measured", "markers": "A;B;C", "group": "lab"},
    {"recording": "simulated", "path": "simulate:walk-and-white", "group": "lab"},
]
CALIBRATIONS = [
    {"calibration": "sim-1-1", "setup": "sim-1", "group": "jansen2019"}
    | {"path": "simulate:sim-1-1", "format": "gpio-dump"}
]
LAST = {"pages", "provenance", "gate", "default"}


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
def computed(tmp_path_factory, root, snakemake):
    """Folder in which everything passes for computed, without a number in it."""
    folder = tmp_path_factory.mktemp("computed")
    file = folder / "given.c3d"
    file.touch()
    arguments = ("--config", *sheets(folder, file, {}), f"results={folder}/results")
    check = folder / "results/recordings/measured/check.json"
    check.parent.mkdir(parents=True)
    check.write_text(json.dumps({"ok": True, "why": "", "warnings": [], "notes": []}) + "\n")
    pass_for_computed(functools.partial(snakemake, root), *arguments)
    return folder


def test_a_source_with_an_older_date_is_computed_anew(computed, root, snakemake) -> None:
    file = computed / "given.c3d"
    arguments = ("-n", "--config", *sheets(computed, file, {}), f"results={computed}/results")

    def plan() -> set[str]:
        return set(planned(snakemake(root, *arguments).stdout)) - LAST

    before = file.stat()
    file.touch()
    assert not plan()
    file.write_text("another recording")
    os.utime(file, ns=(0, 0))
    try:
        assert plan() == {"clean"}  # on which the others depend
    finally:
        file.write_text("")
        os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))


def test_a_changed_cell_computes_anew_what_reads_its_column(computed, root, snakemake) -> None:
    changes = {
        "words": {
            "measured": {"date": "2024-05-01"},
            "simulated": {"comment": "to be left out"},
            "sim-1-1": {"comment": "moved"},
        },
        "group": {"simulated": {"group": "hall"}},
        "pairs": {"measured": {"pairs": "A-C"}},
    }
    expected = {
        "words": {"group_tables"},  # which has a column of comments
        "group": {"verdict", "group_tables"},
        "pairs": {"clean"},
    }

    def plan(name: str) -> str:
        given = sheets(computed / name, computed / "given.c3d", changes[name])
        return snakemake(root, "-n", "--config", *given, f"results={computed}/results").stdout

    found = side_by_side(*(functools.partial(plan, name) for name in changes))
    for (name, rules), output in zip(expected.items(), found, strict=True):
        assert set(planned(output)) - LAST == rules, (name, output)
