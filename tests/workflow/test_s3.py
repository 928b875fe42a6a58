"""Recordings that the sheets name by their place in S3, on a server of this computer."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
import small_run
from mocap_workflow import remote, rows
from mocap_workflow.recordings import RecordingRow
from running import write_sheet

from mocap_metrology.common.faults import Faults
from mocap_metrology.common.files import sha256

BUCKET = "recordings"
FILES = ("take.c3d", "angles.csv", "board.csv")
RECORDING = ["recording", "path", "markers", "group", "sha256"]
CALIBRATION = ["calibration", "setup", "group", "path", "format", "board", "sha256"]
TARGETS = ("recordings/measured/trajectories.parquet", "calibrations/angles/sweeps.parquet")


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Address of a server with an empty bucket, which Snakemake will ask."""
    moto = pytest.importorskip("moto.server", reason="needs `make s3`")
    boto3 = pytest.importorskip("boto3", reason="needs `make s3`")
    pytest.importorskip(remote.PLUGIN, reason="needs `make s3`")
    server = moto.ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    address = f"http://{host}:{port}"
    for key in ("ACCESS_KEY_ID", "SECRET_ACCESS_KEY"):
        monkeypatch.setenv(f"AWS_{key}", "test")
    monkeypatch.setenv("SNAKEMAKE_STORAGE_S3_ENDPOINT_URL", address)
    monkeypatch.setenv("NO_PROXY", host)
    boto3.client("s3", endpoint_url=address, region_name="us-east-1").create_bucket(Bucket=BUCKET)
    yield address
    server.stop()


def write_sheets(folder: Path, where: str, sums: dict[str, str]) -> tuple[str, str]:
    """Sheets of both kinds whose files are at `where`, and a recording with a wrong checksum."""
    take = {"path": f"{where}take.c3d", "markers": "A;B", "group": "lab"}
    angles = {"path": f"{where}angles.csv", "board": f"{where}board.csv", "format": "angles-csv"}
    recordings = write_sheet(
        folder,
        RECORDING,
        take | {"recording": "measured", "sha256": sums["take.c3d"]},
        take | {"recording": "wrong", "sha256": "0" * 64},
    )
    recordings = (folder / recordings).rename(folder / "recordings.tsv").name
    names = {"calibration": "angles", "setup": "room", "group": "lab"}
    calibrations = write_sheet(folder, CALIBRATION, names | angles | {"sha256": sums["angles.csv"]})
    return recordings, calibrations


def run(snakemake, folder: Path, where: str, sums: dict[str, str]):
    recordings, calibrations = write_sheets(folder, where, sums)
    (folder / "profiles").symlink_to(small_run.ROOT / "profiles")
    wanted = [f"results/{target}" for target in (*TARGETS, "recordings/wrong/check.json")]
    return snakemake(
        folder,
        *("--cores", "2", "--snakefile", str(small_run.ROOT / "Snakefile"), *wanted),
        *("--config", f"recordings={recordings}", f"calibrations={calibrations}"),
    )


def test_results_are_those_of_local_files(tmp_path: Path, snakemake, server: str) -> None:
    import boto3

    here, there = small_run.write_inputs(tmp_path / "here"), tmp_path / "there"
    there.mkdir()
    client = boto3.client("s3", endpoint_url=server, region_name="us-east-1")
    for name in FILES:
        client.upload_file(str(here / name), BUCKET, f"lab/{name}")
    sums = {name: sha256(here / name) for name in FILES}
    local = run(snakemake, here, "", sums)
    distant = run(snakemake, there, f"s3://{BUCKET}/lab/", sums)
    assert local.returncode == 0, local.stdout
    assert distant.returncode == 0, distant.stdout
    for folder in (here, there):
        check = json.loads((folder / "results/recordings/wrong/check.json").read_text())
        assert check["why"] == f"take.c3d: SHA-256 is {sums['take.c3d']}; expected {'0' * 64}"
    found, expected = (small_run.digests(folder / "results") for folder in (there, here))
    assert found == expected


def test_without_the_plugin_the_row_is_refused(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(remote, "PLUGIN", "no_such_plugin")
    row = {"recording": "a", "path": "s3://lab/a.c3d", "markers": "A", "group": "g"}
    sheet = write_sheet(folder, RECORDING, row)
    with pytest.raises(Faults) as refused:
        rows.load(RecordingRow, sheet, ())
    assert str(refused.value) == (
        'sheet.tsv, row 2 (recording "a"), column path: "s3://lab/a.c3d"; expected a file of this '
        "computer, or the plugin that reads S3 (`make s3`)"
    )


@pytest.mark.parametrize(
    "path", ["s3://", "s3://lab", "s3://lab/", "s3://lab/../a", "s3://lab/{a}"]
)
def test_what_names_no_object_is_refused(folder: Path, path: str) -> None:
    row = {"recording": "a", "path": path, "markers": "A", "group": "g"}
    with pytest.raises(Faults) as refused:
        rows.load(RecordingRow, write_sheet(folder, RECORDING, row), ())
    assert str(refused.value).endswith("expected s3://bucket/key without any of < > { }")
