"""What the workflow would do, asked of Snakemake itself."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from running import finished, planned, side_by_side


def test_both_entries_list_the_same_jobs_and_quick_outlives_other_settings(
    toy: Path, root: Path, snakemake
) -> None:
    expected = {"clean": 3, "gate": 1}
    (toy / "config/quick.yaml").write_text((root / "config/quick.yaml").read_text())
    with (toy / "workflow/Snakefile").open("a") as stream:
        stream.write('\nprint("duration", config["duration_s"], config["hampel"])\n')
    quick = ("--profile", "profiles/quick", "--config", "hampel={action: mask}")
    top, inner = side_by_side(
        lambda: snakemake(toy, "-n"),
        lambda: snakemake(toy, "-n", "-s", "workflow/Snakefile", *quick),
    )
    assert planned(top.stdout) == expected | {"default": 1}, top.stdout
    assert planned(inner.stdout) == expected | {"all": 1}, inner.stdout
    hampel = {"half_window_s": 1.0, "n_sigma": 3.0, "action": "mask"}
    assert f"duration 600.0 {hampel}" in inner.stdout, inner.stdout


def test_no_rows_are_nothing_to_do_and_a_folder_without_configuration_gets_the_projects(
    toy: Path, tmp_path_factory: pytest.TempPathFactory, snakemake
) -> None:
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    (elsewhere / "profiles").symlink_to(toy / "profiles")
    entry = ("-s", str(toy / "Snakefile"))
    empty = ("--cores", "1", "--config", "recordings=")
    done, nothing = side_by_side(
        lambda: snakemake(elsewhere, "-n", *entry),
        lambda: snakemake(elsewhere, *entry, *empty),
    )
    assert planned(done.stdout)["clean"] == 3, done.stdout
    assert nothing.returncode == 0
    assert finished(nothing.stdout) == {"default": 1}
    assert not (elsewhere / "results").exists()


def test_wrong_input_is_lines_and_status_1(toy: Path, snakemake) -> None:
    (toy / "config/mine.tsv").write_text(
        "recording\tpath\tmarkers\tgroup\na\tno.c3d\tA\tg\nb\tsimulate:U\t\tg\n"
    )
    (toy / "config/dumps.tsv").write_text("calibration\tsetup\n")
    wrong = ("recording=x", "seed=-1")
    named = ("recordings=config/mine.tsv", "calibrations=config/dumps.tsv")
    (toy / "config/mine.yaml").write_text("seed: 1\nnoise: {}\nseed: 2\n")
    settings, sheets, twice = side_by_side(
        lambda: snakemake(toy, "-n", "--config", *wrong),
        lambda: snakemake(toy, "-n", "--config", *named),
        lambda: snakemake(toy, "-n", "--configfile", "config/mine.yaml"),
    )
    assert twice.returncode == 1
    line = "no readable YAML or JSON: line 3: key seed is repeated; expected once"
    assert twice.stdout.splitlines()[-1].endswith(f"config/mine.yaml: {line}")
    assert settings.returncode == 1
    assert settings.stdout.splitlines()[-2:] == [
        "config, key recording: unknown; did you mean recordings?",
        "config, key seed: -1; expected a whole number >= 0",
    ]
    assert sheets.returncode == 1
    assert sheets.stdout.splitlines()[-3:] == [
        'config/mine.tsv, row 2 (recording "a"), column path: "no.c3d"; '
        "expected a file (config/no.c3d does not exist)",
        'config/mine.tsv, row 3 (recording "b"), column path: "simulate:U"; '
        "expected simulate: and a twin of the file of twins (unknown; expected one of T)",
        "config/dumps.tsv: no column group, path, format; expected a header with it",
    ]
    assert "Traceback" not in settings.stdout + sheets.stdout


def test_a_marker_that_the_file_lacks_is_refused_before_anything_runs(
    toy: Path, root: Path, snakemake
) -> None:
    """A damaged file beside it is another fault, which the check of its row names."""
    shutil.copy(root / "docs/example/kinematics_racing_static.c3d", toy / "config/a.c3d")
    (toy / "config/b.c3d").write_bytes(b"damaged")
    (toy / "config/mine.tsv").write_text(
        "recording\tpath\tmarkers\tgroup\n"
        "a\ta.c3d\tWheelchairRearR;WheelchairRaerL\tg\nb\tb.c3d\tA\tg\n"
    )
    done = snakemake(toy, "-n", "--config", "recordings=config/mine.tsv", "calibrations=")
    assert done.returncode == 1
    assert done.stdout.splitlines()[-1] == (
        "recordings, recording \"a\", column markers: a.c3d: no marker 'WheelchairRaerL';"
        " did you mean WheelchairRearL?"
    )
