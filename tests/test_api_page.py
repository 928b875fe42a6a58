"""The public names, and the lines of docs/api.md and of the notebook that use them."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import ezc3d
import numpy as np
import pytest
from mocap_workflow.calibration_twins import calibration_twin

import mocap_metrology as mm
from mocap_metrology import face
from mocap_metrology.common.entries import load_twins
from mocap_metrology.lighthouse.simulate import recording as lighthouse

PAGE_NAMES = re.compile(r"`mm\.(\w+)")


def write_dump(folder: Path, root: Path) -> np.ndarray:
    """dump.bin and board.csv of a twin; the true place of the slave in mm."""
    document = load_twins(str(root / "config/twins.yaml"))
    made = lighthouse.simulate(calibration_twin(document, "real-1-1"))
    lighthouse.write_dump(folder / "dump.bin", made.pulses)
    np.savetxt(
        folder / "board.csv", made.truth.board, "%.6f", ",", header="x_m,y_m,z_m", comments=""
    )
    return 1000 * made.truth.t_optical_m


def test_the_lines_of_the_page(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On the example of the README and a simulated dump; values against what was simulated."""
    place_mm = write_dump(tmp_path, root)
    (tmp_path / "docs").symlink_to(root / "docs")
    page = (root / "docs/api.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for code in re.findall(r"```python\n(.*?)```", page, re.DOTALL):
        exec(code, names)
    by_ezc3d = ezc3d.c3d(str(root / "docs/example/kinematics_racing_static.c3d"))
    points = by_ezc3d["data"]["points"][:3]
    known = by_ezc3d["parameters"]["POINT"]["LABELS"]["value"]
    first, second = (points[:, known.index(label)] for label in names["take"].labels)
    assert np.allclose(names["distance"], 1000 * np.linalg.norm(first - second, axis=0), atol=1e-3)
    white = names["curve"].iloc[0]
    assert white["adev_mm"] == pytest.approx(np.std(np.diff(names["distance"])) / 2**0.5, rel=0.3)
    error = white["adev_mm"] / np.sqrt(2 * white["edf"])  # of many degrees of freedom
    assert white["adev_upper_mm"] - white["adev_mm"] == pytest.approx(error, rel=0.2)
    assert white["adev_mm"] - white["adev_lower_mm"] == pytest.approx(error, rel=0.2)
    table = names["mm"].noise(names["x1"], 120.0).set_index("parameter")
    assert table.loc["h_0", "value"] == pytest.approx(1e-6, rel=0.05)
    assert table.loc["h_-2", "lower_95"] < 1e-9 < table.loc["h_-2", "upper_95"]
    ratio = names["mm"].compare(2 * names["x1"], names["x1"], 120.0)
    assert np.allclose(ratio["ratio"], 2)
    assert np.linalg.norm(1000 * names["pose"].t_m - place_mm) < 30


def test_the_page_lists_the_public_names(root: Path) -> None:
    page = (root / "docs/api.md").read_text(encoding="utf-8")
    assert set(PAGE_NAMES.findall(page.partition("```python")[0])) == set(mm.NAMES)
    assert set(mm.NAMES) == set(face.__all__) and set(dir(mm)) == set(mm.NAMES)
    for name in mm.NAMES:
        assert callable(getattr(mm, name)), name
    with pytest.raises(AttributeError, match="no_such"):
        mm.no_such  # noqa: B018


def test_the_package_is_imported_without_what_is_heavy() -> None:
    code = "import sys, mocap_metrology; print({'numpy', 'pandas', 'scipy'} & {*sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


def test_the_cells_of_the_notebook(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The verdict is that of the README; the lowest Allan deviation is drawn."""
    example = shutil.copytree(root / "docs/example", tmp_path / "example")
    notebook = json.loads((example / "check.ipynb").read_text(encoding="utf-8"))
    monkeypatch.chdir(example)
    names: dict[str, Any] = {}
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
    written = json.loads((example / "checked/verdict.json").read_text(encoding="utf-8"))
    assert names["verdict"]["word"] == written["word"] == "usable"
    drawn = names["ax"].get_lines()[0].get_ydata()
    assert min(drawn) == names["curve"]["adev_mm"].min()
