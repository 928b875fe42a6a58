"""A recording as C3D, TRC and a table without names through the workflow: the same deviations."""

from __future__ import annotations

import json

import numpy as np
import pyarrow.parquet as pq
import pytest
from running import write_sheet

from mocap_metrology.common.files import sha256

HEADER = ["recording", "path", "markers", "group", "pairs", "frame_rate_hz", "truncated", "sha256"]
HEADER += ["unit", "column_names"]
C3D = "kineticstoolkit/kinematics_racing_static.c3d"
MARKERS = ["WheelchairFront", "WheelchairRearR"]


def write_trc(path, source) -> None:
    """What ezc3d reads of these two markers, in mm with six decimals; the rate is left out."""
    ezc3d = pytest.importorskip("ezc3d")
    file = ezc3d.c3d(str(source))
    labels = file["parameters"]["POINT"]["LABELS"]["value"]
    points = file["data"]["points"][:3, [labels.index(name) for name in MARKERS]] * 1000
    n = points.shape[2]
    keys = "DataRate CameraRate NumFrames NumMarkers Units OrigDataRate OrigDataStartFrame"
    lines = [
        f"PathFileType\t4\t(X/Y/Z)\t{path.name}",
        "\t".join([*keys.split(), "OrigNumFrames"]),
        f"0\t0\t{n}\t2\tmm\t0\t1\t{n}",
        "Frame#\tTime\t" + "\t\t\t".join(MARKERS) + "\t\t",
        "\t\t" + "\t".join(f"{axis}{k}" for k in (1, 2) for axis in "XYZ"),
        "",
    ]
    rate = float(file["header"]["points"]["frame_rate"])
    for i, frame in enumerate(points.transpose(2, 1, 0).reshape(n, 6)):
        cells = ["" if np.isnan(value) else f"{value:.6f}" for value in frame]
        lines.append("\t".join([f"{i + 1}", f"{i / rate:.6f}", *cells]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


@pytest.fixture(scope="module")
def both(samples, tmp_path_factory, root, snakemake):
    """Folder of results and the output of one run: the C3D row, the TRC row, a TRC cut off."""
    folder = tmp_path_factory.mktemp("formats")
    source = samples / "c3d" / C3D
    write_trc(folder / "take.trc", source)
    text = (folder / "take.trc").read_bytes()
    rows = text.decode().splitlines()[6:]
    (folder / "rows.csv").write_text("\n".join([*rows, ""]).replace("\t", ","))
    names = " ".join(["frame", "time", *(f"{name}_{axis}" for name in MARKERS for axis in "xyz")])
    (folder / "cut.trc").write_bytes(text[: len(text) // 2])
    common = {"markers": ";".join(MARKERS), "group": "g"}
    sheet = write_sheet(
        folder,
        HEADER,
        common | {"recording": "c3d", "path": str(source)},
        common
        | {"recording": "trc", "path": "take.trc", "frame_rate_hz": "69.9"}
        | {"sha256": sha256(folder / "take.trc")},
        common
        | {"recording": "table", "path": "rows.csv", "unit": "mm", "column_names": names}
        | {"frame_rate_hz": "69.9"},
        common | {"recording": "cut", "path": "cut.trc", "frame_rate_hz": "69.9"},
    )
    results = folder / "results"
    wanted = [results / f"recordings/{name}/allan.parquet" for name in ("c3d", "trc", "table")]
    out = snakemake(
        root,
        *("--cores", "2", *wanted, results / "recordings/cut/check.json", "--config"),
        *(f"recordings={folder / sheet}", "calibrations=", f"results={results}"),
    )
    return results, out


def test_the_same_deviations(both) -> None:
    """Six decimals of a millimetre: 3e-7 mm of rounding beside noise of 1e-2 mm."""
    results, out = both
    assert out.returncode == 0, out.stdout
    theirs, ours, named = (
        pq.read_table(results / f"recordings/{name}/allan.parquet").to_pandas()
        for name in ("c3d", "trc", "table")
    )
    assert named.equals(ours)
    assert len(ours) > 100 and set(ours["series"]) == {*["x1", "y1", "z1", "x2", "y2", "z2", "L"]}
    assert ours[["series", "estimator", "m"]].equals(theirs[["series", "estimator", "m"]])
    np.testing.assert_allclose(ours["adev_mm"], theirs["adev_mm"], rtol=1e-4)


def test_what_is_kept_of_a_text(both) -> None:
    results, _ = both
    found = pq.read_schema(results / "recordings/trc/trajectories.parquet").metadata
    origin = json.loads(found[b"mocap_metrology"])
    assert origin["frame_rate_hz"] == 69.9
    assert (origin["file_encoding"], origin["file_units"]) == ("TRC text", "mm")
    assert origin["segments"][0]["frame_count_source"] == "NumFrames"
    assert origin["labels"] == MARKERS


def test_a_refusal_says_what_to_write(both) -> None:
    results, _ = both
    check = json.loads((results / "recordings/cut/check.json").read_text(encoding="utf-8"))
    assert not check["ok"]
    assert check["why"].startswith("cut.trc: cut off: ")
    assert check["why"].endswith('write "accept" in column truncated of the sheet')
