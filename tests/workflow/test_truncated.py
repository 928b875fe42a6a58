"""Files that are cut off: refused with what to do, and wholly usable where they are accepted."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from running import write_sheet
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal, Truncated
from mocap_metrology.io.read import read_recording

N, RATE = 2400, 100.0
TRC = """PathFileType\t4\t(X/Y/Z)\tcut.trc
DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames
100\t100\t{declared}\t2\tmm\t100\t1\t{declared}
Frame#\tTime\tA\t\t\tB\t\t
\t\tX1\tY1\tZ1\tX2\tY2\tZ2

"""


def trc(path: Path, n: int, declared: int) -> Path:
    noise = np.random.default_rng(2).normal([1, 2, 3, 400, 5, 6], 0.1, (n, 6))
    lines = [
        "\t".join([str(k + 1), f"{k / RATE:.3f}", *(f"{v:.5f}" for v in row)])
        for k, row in enumerate(noise)
    ]
    path.write_text(TRC.format(declared=declared) + "\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_a_file_that_is_cut_off_needs_a_word(tmp_path) -> None:
    path = trc(tmp_path / "cut.trc", 150, 200)
    with pytest.raises(Truncated, match=r"cut.trc: cut off: 150 of the 200 frames that NumFrames"):
        read_recording([path], ["A"])
    found = read_recording([path], ["A", "B"], accept_truncated=True)
    assert found.position_mm.shape == (2, 3, 150)


def test_nothing_to_accept_is_not_offered(tmp_path) -> None:
    """Neither of a header alone, nor of a letter among the numbers."""
    head = tmp_path / "head.trc"
    head.write_text("\n".join(TRC.splitlines()[:3]) + "\n", encoding="utf-8")
    letter = trc(tmp_path / "letter.trc", 200, 200)
    letter.write_text(letter.read_text().replace("\t0.500\t", "\tx.500\t"), encoding="utf-8")
    for path, why in ((head, "head.trc: cut off: 3 lines"), (letter, "letter.trc: line 57, ")):
        with pytest.raises(Refusal, match=why) as caught:
            read_recording([path], ["A"])
        assert not isinstance(caught.value, Truncated)


def test_orientation_of_accepted_poses(tmp_path, root, snakemake) -> None:
    """The last line ends within a number; the noise is of known size, in rad."""
    rng = np.random.default_rng(11)
    turn = rng.normal(0, 1e-3, (N, 3))
    matrix = Rotation.from_rotvec(turn).as_matrix()
    poses = np.concatenate([matrix, rng.normal(0, 1e-4, (N, 3, 1))], axis=2).reshape(N, 12)
    text = "\n".join(" ".join(f"{v:.9f}" for v in row) for row in poses)
    (tmp_path / "poses.txt").write_text(text[:-40], encoding="utf-8")
    row = {"recording": "cut", "path": "poses.txt", "markers": "tracker", "group": "g"}
    row |= {"frame_rate_hz": str(RATE), "truncated": "accept"}
    sheet = write_sheet(tmp_path, list(row), row)
    table = tmp_path / "results/recordings/cut/orientation.csv"
    options = (f"recordings={tmp_path / sheet}", "calibrations=", f"results={tmp_path / 'results'}")
    done = snakemake(root, "--cores", "2", str(table), "--config", *options)
    assert done.returncode == 0, done.stdout
    with table.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    one_frame = [float(r["adev_1_rad"]) for r in rows]
    assert len(one_frame) == 3
    np.testing.assert_allclose(one_frame, 1e-3, rtol=0.1)  # 6 standard errors
