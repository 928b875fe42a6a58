"""The archive of a finished run: what its metadata name is in it, and the run is described."""

import json
import os
import zipfile
from pathlib import Path

import pytest
import write_crate


@pytest.fixture
def results(tmp_path: Path) -> Path:
    """A folder as a run leaves it: a table, a recording, a benchmark of 60 s."""
    inputs = [
        {"name": "a", "kind": "recording", "source": "measured", "seed": None}
        | {"file": "a.c3d", "sha256": "ab" * 32},
        {"name": "b", "kind": "calibration", "source": "twin", "seed": 0}
        | {"file": None, "sha256": None},
    ]
    code = {"version": "0.1.0", "commit": "c0ffee", "python": "3.11"}
    document = {"inputs": inputs, "code": code, "packages": {"snakemake": "9.27.1"}}
    texts = {
        "provenance.json": json.dumps(document),
        "tables/g_noise.csv": "x\n",
        "recordings/a/allan.parquet": "x",
        "benchmarks/noise/a.tsv": "s\tmax_rss\n60.0\t1\n",
        "logs/noise/a.log": "x",
    }
    for name, text in texts.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        os.utime(path, (1_000_000_000, 1_000_000_000))
    return tmp_path


def test_what_the_metadata_name_is_in_the_archive_and_the_run_is_described(results: Path) -> None:
    assert write_crate.main([str(results)]) == 0
    with zipfile.ZipFile(results / "crate.zip") as archive:
        names = set(archive.namelist()) - {write_crate.METADATA}
        graph = json.loads(archive.read(write_crate.METADATA))["@graph"]
    entities = {one["@id"]: one for one in graph}
    assert len(entities) == len(graph)
    assert {one["@id"] for one in graph if "File" in one["@type"]} == names
    assert {one["@id"] for one in entities["./"]["hasPart"]} == names
    assert {"results/tables/g_noise.csv", "workflow/Snakefile", "LICENSE"} <= names
    assert not [name for name in names if name.endswith(".parquet") or "/logs/" in name]
    linked = [v["@id"] for one in graph for v in one.values() if isinstance(v, dict)]
    outside = {"https://w3id.org/ro/crate/1.1", "https://snakemake.github.io"}
    assert set(linked) - outside <= entities.keys()
    run = entities["#run"]
    assert run["startTime"] == "2001-09-09T01:45:40+00:00"
    assert run["endTime"] == "2001-09-09T01:46:40+00:00"
    given = {one["@id"] for one in run["object"]}
    assert {"#input-0", "#input-1", "config/config.yaml"} <= given
    assert {"@id": "results/tables/g_noise.csv"} in run["result"]
    assert entities["#input-0"]["sha256"] == "ab" * 32
    assert entities["#input-1"]["description"] == "calibration, twin, seed 0"


def test_a_folder_without_a_finished_run_is_refused(tmp_path: Path, capsys) -> None:
    assert write_crate.main([str(tmp_path)]) == 1
    expected = "no provenance.json; expected results of a finished run"
    assert capsys.readouterr().err == f"{tmp_path}: {expected}\n"
