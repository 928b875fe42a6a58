"""What the workflow would do, asked of Snakemake itself."""

import csv
import shutil
from pathlib import Path

import pytest
from mocap_workflow import rows, startup
from mocap_workflow.calibrations import CalibrationRow
from mocap_workflow.recordings import RecordingRow
from running import faults_of, finished, planned, side_by_side, write_sheet

from mocap_metrology.common import sheets

GROUPS = {  # of the default sheets
    "recordings": {
        *("skurowski2019", "skurowski2019-crump", "skurowski2019-repaired"),
        "example-failing-camera",
    },
    "calibrations": {"jansen2019"},
}


def shipped(root: Path, sheet: str) -> list[dict[str, str]]:
    """Rows of a sheet that the project came with, whatever a user has added: cells by column."""
    kind = RecordingRow if sheet == "recordings" else CalibrationRow
    rows = sheets.read(root / f"config/{sheet}.tsv", list(kind.columns()), kind.required())
    return [
        row.cells
        for row in rows
        if row.cells["group"] in GROUPS[sheet] and row.cells["path"].startswith("simulate:")
    ]


def test_both_entries_list_the_same_jobs_and_quick_outlives_other_settings(
    toy: Path, root: Path, tmp_path_factory: pytest.TempPathFactory, snakemake
) -> None:
    """The outer one from a folder without configuration, which gets the project's. No rows are
    nothing to do."""
    expected, elsewhere = {"clean": 3, "gate": 1}, tmp_path_factory.mktemp("elsewhere")
    (elsewhere / "profiles").symlink_to(toy / "profiles")
    (toy / "config/quick.yaml").write_text((root / "config/quick.yaml").read_text())
    with (toy / "workflow/Snakefile").open("a") as stream:
        stream.write('\nprint("duration", config["duration_s"], config["hampel"])\n')
    entry = ("-s", str(toy / "Snakefile"))
    quick = ("--profile", "profiles/quick", "--config", "hampel={action: mask}")
    top, inner, nothing = side_by_side(
        lambda: snakemake(elsewhere, "-n", *entry),
        lambda: snakemake(toy, "-n", "-s", "workflow/Snakefile", *quick),
        lambda: snakemake(elsewhere, *entry, "--cores", "1", "--config", "recordings="),
    )
    assert planned(top.stdout) == expected | {"default": 1}, top.stdout
    assert planned(inner.stdout) == expected | {"all": 1}, inner.stdout
    hampel = {"half_window_s": 1.0, "n_sigma": 3.0, "action": "mask"}
    assert f"duration 600.0 {hampel}" in inner.stdout, inner.stdout
    assert nothing.returncode == 0
    assert finished(nothing.stdout) == {"default": 1}
    assert not (elsewhere / "results").exists()


def test_a_marker_that_the_file_lacks_is_refused_before_anything_runs(
    folder: Path, root: Path
) -> None:
    """A damaged file beside it is another fault, which the check of its row names."""
    shutil.copy(root / "docs/example/kinematics_racing_static.c3d", folder / "a.c3d")
    cells = {"path": "a.c3d", "markers": "WheelchairRearR;WheelchairRaerL", "group": "g"}
    beside = {"path": "b.c3d", "markers": "A", "group": "g"}
    bar = {"path": "a.c3d", "bar": "WheelchairRearR-RearL", "group": "g"}
    named = [row | {"recording": name} for row, name in ((cells, "a"), (beside, "b"), (bar, "c"))]
    sheet = write_sheet(folder, ["recording", *cells, "bar"], *named)
    of_marker, of_bar = faults_of(
        startup.missing_markers, rows.load(RecordingRow, sheet, []).values()
    )
    assert of_marker == (
        "recordings, recording \"a\", column markers: a.c3d: no marker 'WheelchairRaerL';"
        " did you mean WheelchairRearL?"
    )
    assert of_bar.startswith(
        'recordings, recording "c", column bar: a.c3d: bar is "WheelchairRearR-RearL"; expected'
        ' auto, or two markers of the file joined by "-": Probe1, '
    )


def test_default_sheet_job_counts(root, tmp_path, snakemake) -> None:
    """One job and one figure for the twins of a setup: the dumps of one look alike."""
    given = {kind: shipped(root, kind) for kind in GROUPS}
    for kind, rows_of_kind in given.items():
        (tmp_path / kind).mkdir()
        write_sheet(tmp_path / kind, [*rows_of_kind[0]], *rows_of_kind)
    own = [f"{kind}={tmp_path}/{kind}/sheet.tsv" for kind in given]
    out = snakemake(root, "-n", "--config", *own, f"results={tmp_path}/results")
    sheet, calibrations = given.values()
    per_recording = ("clean_twin", "noise", "verdict")
    once = (
        *("skurowski", "expected_noise", "jansen", "calibration_tables", "claims"),
        *("gate", "default"),
    )
    expected = dict.fromkeys(per_recording, len(sheet)) | dict.fromkeys(once, 1)
    groups = len({row["group"] for row in sheet})
    expected |= {"group_tables": groups, "noise_tables": groups}
    setups = {row["setup"] for row in calibrations}
    expected |= {f"calibration_twins_{k}": 1 for k in range(1, len(setups) + 1)}
    expected |= {"calibration_figures": len(setups)}
    paper = [(r["camera_type"], r["n_cameras"]) for r in sheet if r["group"] == "skurowski2019"]
    found = planned(out.stdout)
    assert {rule: found[rule] for rule in expected} == expected, out.stdout
    cited = (root / "src/mocap_metrology/reference/camera_subsets_table3.csv").read_text()
    table_3 = csv.DictReader(cited.splitlines())
    assert {(r["camera_type"], r["n_cameras"]) for r in table_3} <= set(paper)
    expected |= {"skurowski_case": 3}
    others = {rule: count for rule, count in found.items() if rule not in expected}
    assert all(count <= 2 for count in others.values()), others  # none for each recording
    assert not {"clean", "sweeps", "pose"} & set(found)  # twins need no check
    assert sum(found.values()) <= 200
