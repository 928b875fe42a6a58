"""The lines of docs/api.md do what the page says, on a simulated recording and a simulated dump."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from mocap_workflow.calibration_twins import calibration_twin
from mocap_workflow.entries import load_twins

from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.lighthouse.simulate import recording as lighthouse
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.simulate import simulate
from mocap_metrology.noise.twins.twin import COORDINATES, Twin

H_0 = 1e-6  # mm^2/Hz: Allan deviation sqrt(h_0 / 2 tau) = 0.00316 mm at 0.05 s


def write_inputs(folder: Path, root: Path) -> np.ndarray:
    """take.c3d, dump.bin and board.csv; the true place of the slave in mm."""
    model = NoiseModel.from_coefficients({"h_0": H_0})
    twin = Twin("page", seed=3, models=dict.fromkeys(COORDINATES, model), duration_s=300)
    frames = np.moveaxis(simulate(twin).position_mm, 2, 0).astype(np.float32)
    write_c3d(folder / "take.c3d", twin.labels, twin.frame_rate_hz, [frames], len(frames))
    document = load_twins(str(root / "config/twins.yaml"))
    made = lighthouse.simulate(calibration_twin(document, "real-1-1").made("real-1-1"))
    lighthouse.write_dump(folder / "dump.bin", made.pulses)
    np.savetxt(
        folder / "board.csv", made.truth.board, "%.6f", ",", header="x_m,y_m,z_m", comments=""
    )
    return 1000 * made.truth.t_optical_m


def test_the_lines_of_the_page(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place_mm = write_inputs(tmp_path, root)
    page = (root / "docs/api.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for code in re.findall(r"```python\n(.*?)```", page, re.DOTALL):
        exec(code, names)
    curve, rate = names["curve"], names["rate"]
    white = np.sqrt(H_0 / (2 * curve.tau_s))  # S Table 1
    short = curve.tau_s < 1
    assert rate == 120
    assert np.allclose(curve.deviation[short], white[short], rtol=0.05)
    assert names["estimate"].values == {"h_0": pytest.approx(H_0, rel=0.05)}
    assert names["made"].position_mm.shape == (2, 3, 72000)
    assert np.linalg.norm(1000 * names["pose"].t_m - place_mm) < 30
