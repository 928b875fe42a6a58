"""A bar of two bodies: angles against a stated rotation; groups of passes."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.accuracy.bar import BarEntry
from mocap_metrology.accuracy.statement import known_of
from mocap_metrology.accuracy.twin import BarErrors, BarTwin, simulate_bar
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import read_csv
from mocap_metrology.recording.bar import (
    passes_of,
    read_bar,
    write_bar,
    write_group,
    write_statement,
    write_take,
)
from mocap_metrology.recording.clean import Entry
from mocap_metrology.settings import Settings

RATE, NAMED = 50.0, {"source": "measured", "twin": None}
CERTIFIED = BarEntry("A-B", 500.0, 0.05)
TURNED = Rotation.from_rotvec([0.0, 0.0, np.radians(1.0)])


def write_bodies(path: Path, seed: int, angle_deg: float = 0.2) -> Path:
    """Two bodies on a bar of 500 mm; B is turned by 1 degree in A, noise of the angle."""
    bar = BarErrors(500.0, pass_mm=0.1, rest=0.2, frame=0.05, bias=1.0)
    ends = simulate_bar(BarTwin("t", bar, seed, 30.0, RATE)).position_mm / 1000
    rng = np.random.default_rng(seed)
    n = ends.shape[2]
    first = Rotation.from_rotvec(np.radians([0, 40, 0]) * np.sin(np.arange(n) / 200)[:, None])
    noise = Rotation.from_rotvec(np.radians(angle_deg) * rng.standard_normal((n, 3)))
    quaternions = [turn.as_quat(scalar_first=True) for turn in (first, first * TURNED * noise)]
    rows = [part for p, q in zip(ends, quaternions, strict=True) for part in (p.T, q)]
    np.savetxt(path, np.hstack(rows), header=f"bodies: A;B quaternion: wxyz Freq: {RATE:g}")
    return path


def of(folder: Path, asked: BarEntry, seed: int) -> Path:
    """A pass in a folder of its name."""
    name = f"pass{seed}"
    made = folder / "recordings" / name
    made.mkdir(parents=True)
    entry = Entry([str(write_bodies(made / "bar.txt", seed))], [])
    named = NAMED | {"recording": name, "date": "2026-03-01T10:00"}
    write_take(read_bar(entry, asked, Settings(), named), asked, made / "bar.parquet")
    return made / "bar.parquet"


@pytest.fixture(scope="module")
def passes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Path]]:
    """Three of a bar with a certificate, and of one without."""
    folder = tmp_path_factory.mktemp("passes")
    asked = {"certified": (CERTIFIED, (1, 2, 3)), "free": (BarEntry("A-B"), (4, 5, 6))}
    return {name: [of(folder, bar, k) for k in seeds] for name, (bar, seeds) in asked.items()}


@pytest.mark.parametrize("stated", [True, False])
def test_angles_of_bodies(tmp_path: Path, stated: bool) -> None:
    """About their own mean: the mean size of a vector of three normal parts, 1.596 sd. Against a
    stated rotation that is 1 degree off: `angle_bias`."""
    pose = json.dumps({"quaternion_xyzw": [0, 0, 0, 1], "u_deg": 0.05}) if stated else None
    made = of(tmp_path, BarEntry("A-B", 500.0, 0.05, pose), 1).parent
    write_bar(made, Settings())
    found = json.loads((made / "bar.json").read_text())
    mean = found["angles_deg"]["mean"]["value"]
    biases = [f["value"] for f in found["findings"] if f["code"] == "angle_bias"]
    if stated:
        assert biases == [pytest.approx(1.0, abs=0.03)] and 1.0 < mean < 1.2
    else:
        assert biases == [] and mean == pytest.approx(0.2 * 1.596, rel=0.05)
    rows = read_csv(made / "bar.csv", ("mean",))
    assert [row["quantity"] for row in rows] == ["length_mm", "angle_deg"]


def test_passes_of_a_group(tmp_path: Path, passes: dict[str, list[Path]]) -> None:
    """Intervals from three passes on; two bars of other certificates stay apart; the noise at rest
    beside them."""
    settings, paths = Settings(), passes["certified"]
    bars = passes_of([*paths, passes["free"][0]], settings)
    assert [len(one.bar.takes) for one in bars] == [3, 1]
    entry, copy = Entry([str(paths[0].with_name("bar.txt"))], []), tmp_path / "copy.parquet"
    named = NAMED | {"recording": "copy", "date": "2026-03-04"}
    backwards = BarEntry("B-A", 500.0, 0.05)
    write_take(read_bar(entry, backwards, settings, named), backwards, copy)
    (twice,) = passes_of([*paths, copy], settings)
    assert [take.name for take in twice.bar.takes] == ["pass1", "pass2", "pass3"]
    assert twice.document["warnings"] == ["copy is the same file as pass1, and counts once"]
    mean = bars[0].bar.every.statistics["mean"]
    assert mean.lower < 1.0 < mean.upper and mean.upper - mean.lower < 1.0
    at_rest = {"series": {"L": {"frame_mm": 0.1}}, "decided_by": {"code": "frame"}}
    moving = {"series": {}, "decided_by": {"code": "bar"}, "bar": {}}
    write_group("lab", paths, [at_rest, moving], settings, tmp_path / "g.json", tmp_path / "g.svg")
    (found,) = json.loads((tmp_path / "g.json").read_text())["bars"]
    codes = {one["code"]: one["value"] for one in found["findings"]}
    assert codes["more_than_still"] == pytest.approx(0.21 / 0.1, rel=0.15)
    assert codes["length_bias"] == pytest.approx(1.0, abs=0.3)
    text = (tmp_path / "g.md").read_text()
    assert "withdrawn in January 2025" in text and "Verdict: usable." in text
    assert (tmp_path / "g.png").exists()


def test_statement_of_a_group(tmp_path: Path, passes: dict[str, list[Path]]) -> None:
    """One page, the same bytes twice; with what a monitor and reference points know. Two passes
    state nothing; a bar without a certificate is precise, not accurate."""
    paths = passes["certified"]
    monitors = [{"series": {"length B-A": {"scatter": 0.4, "dof": 12}, "length A-C": {}}}]
    known = known_of(["A", "B"], monitors, {"n_places": 10, "scale_se_ppm": 300.0})
    (bar,) = passes_of(paths, Settings())
    for name in ("one", "two"):
        write_statement("lab", bar, known, tmp_path / f"{name}.json", tmp_path / f"{name}.pdf")
    for ending in ("json", "csv", "md", "pdf", "png"):
        one, two = ((tmp_path / f"{name}.{ending}").read_bytes() for name in ("one", "two"))
        assert one == two and one
    found = json.loads((tmp_path / "one.json").read_text())
    (told,) = found["statements"]
    sizes = {part["name"]: part["u_mm"] for part in told["budget"]}
    assert sizes["drift"] == 0.4 and sizes["scale"] == pytest.approx(0.15)
    assert told["U_mm"] == pytest.approx(told["k"] * np.linalg.norm(list(sizes.values())))
    assert told["correction_mm"] == pytest.approx(-1.0, abs=0.3)
    assert sum(part["share"] for part in told["budget"]) == pytest.approx(1)
    assert "a delay of both ends alike" in found["not_covered"]
    rows = read_csv(tmp_path / "one.csv", ("u_mm",))
    assert [row["contribution"] for row in rows][-1] == "combined"
    (few,) = passes_of(paths[:2], Settings())
    write_statement("lab", few, known_of(["A", "B"]), tmp_path / "f.json", tmp_path / "f.pdf")
    assert "No uncertainty can be stated: 2 passes" in (tmp_path / "f.md").read_text()
    (bar,) = passes_of(passes["free"], Settings())
    write_statement("lab", bar, known_of(["A", "B"]), tmp_path / "p.json", tmp_path / "p.pdf")
    text = (tmp_path / "p.md").read_text()
    assert "Precise to" in text and "No accuracy can be stated" in text


@pytest.mark.parametrize("pose", ["{}", "[1]", '{"quaternion_xyzw": [1, 1, 0, 0]}', "x"])
def test_what_is_no_rotation_is_refused(pose: str) -> None:
    with pytest.raises(Refusal, match=r"bar_pose is .*expected JSON such as"):
        _ = BarEntry("A-B", bar_pose=pose).pose
