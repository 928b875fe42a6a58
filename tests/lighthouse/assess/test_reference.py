"""References: pose files, markers on mounts against scipy's rotations, station ids."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.assess import reference as ref
from mocap_metrology.lighthouse.records import Station

MOUNT = {
    "M1": np.array([0.05, 0.06, 0.05]),
    "M2": np.array([0.04, -0.07, 0.04]),
    "M3": np.array([-0.05, 0.02, 0.09]),
    "M4": np.array([-0.07, -0.05, 0.01]),
}
SLAVE = ["S1", "S2", "S3", "S4"]
TRUE = Rotation.from_euler("ZYX", [-40, 8, 15], degrees=True).as_matrix()
T = np.array([0.4, 2.1, -0.2])


def seen(noise_mm=0.0, frames=50, seed=1):
    """Markers of both housings in a laboratory's own frame, mm."""
    rng = np.random.default_rng(seed)
    Q, shift = Rotation.random(rng=rng).as_matrix(), rng.normal(size=3)
    places = np.array(list(MOUNT.values()))
    lab = np.concatenate([places, places @ TRUE.T + T]) @ Q.T + shift
    return 1e3 * lab[:, :, None] + noise_mm * rng.standard_normal((8, 3, frames))


def pose_file(tmp_path, **entries):
    given = {"R": TRUE.tolist(), "t_m": T.tolist(), "stations": {"master": 11, "slave": 12}}
    path = tmp_path / "truth.json"
    path.write_text(json.dumps({k: v for k, v in (given | entries).items() if v is not None}))
    return path


def labels():
    return [*MOUNT, *SLAVE]


def test_markers_give_the_relative_pose_whatever_the_laboratory_frame():
    found = ref.reference_from_markers(seen(), labels(), list(MOUNT), SLAVE, MOUNT)
    np.testing.assert_allclose(found.R, TRUE, atol=1e-12)
    np.testing.assert_allclose(found.t_m, T, atol=1e-12)
    assert max(found.residual_mm) < 1e-9 and found.n_markers == (4, 4)
    three = dict(list(MOUNT.items())[:3])
    found = ref.reference_from_markers(seen(), labels(), list(three), SLAVE[:3], three)
    assert found.n_markers == (3, 3)


def test_what_markers_are_refused_for():
    def refused(match, positions=None, master=None, slave=None, mount=MOUNT, names=None):
        with pytest.raises(Refusal, match=match) as error:
            ref.reference_from_markers(
                seen() if positions is None else positions,
                names or labels(),
                list(MOUNT) if master is None else master,
                SLAVE if slave is None else slave,
                mount,
            )
        assert "\n" not in str(error.value)

    refused("mount of the slave: labels are 'S1;S2'", slave=["S1", "S2"])
    refused("S1 is not in the mount's geometry", slave=SLAVE[:3])
    refused("marker M3 is not in the recording", names=["M1", "M2", "X", "M4", *SLAVE])
    moved = seen()
    moved[5, 0] += 40
    refused("mount of the slave: markers are .* check marker S2 first", moved)
    refused("at most 5 mm", master=["M2", "M1", "M3", "M4"], mount=MOUNT, names=[
        "M2", "M1", "M3", "M4", *SLAVE])  # fmt: skip
    gone = seen()
    gone[1] = np.nan
    refused("marker M2 is not visible in any frame", gone)
    shaken = seen()
    shaken[0, 1] += np.linspace(0, 100, 50)
    refused("marker M1 moves by", shaken)
    swaying = np.sin(np.linspace(0, 12 * np.pi, 50, endpoint=False)) * 2**0.5  # 1 mm rms
    for fits in (True, False):
        shaken, off = seen(), seen()
        shaken[0, 1] += (4.99 if fits else 5.01) * swaying
        off[4:] += (8 if fits else 12) * np.array([1, -1, 0, 0])[:, None, None] / 6**0.5
        for positions, why in ((shaken, "moves by 5.0 mm rms"), (off, "mm rms from the mount")):
            if fits:
                ref.reference_from_markers(positions, labels(), list(MOUNT), SLAVE, MOUNT)
            else:
                refused(why, positions)
    line = {k: np.array([0.03 * i, 0.0, 0.0]) for i, k in enumerate(MOUNT)}
    refused("on one line", mount=line)


def test_errors_are_in_master_axes_and_never_differences_of_euler_angles():
    reference = ref.Reference(TRUE, T)
    small = Rotation.from_rotvec([0.01, -0.02, 0.03])
    mm, deg = ref.errors(small.as_matrix() @ TRUE, np.add(T, [0.001, 0, -0.002]), reference)
    np.testing.assert_allclose(mm, [1, 0, -2], atol=1e-9)
    np.testing.assert_allclose(deg, np.degrees([0.01, -0.02, 0.03]), atol=1e-9)


def test_optical_frames_are_where_the_lasers_are():
    """A point seen from displaced lasers has the angles it has from the optical origin, if the two
    lasers of a station are equally deep."""
    lasers = np.array([[[0.01, 0.002, 9], [0.01, 9, -0.004]], [[0.02, 0.03, 9], [0.02, 9, 0.05]]])
    found = ref.optical(ref.Reference(TRUE, T), lasers)
    point = np.array([3.0, 1.0, 0.5])  # in the master's housing
    in_slave = TRUE.T @ (point - T)
    axis0, axis1 = in_slave - lasers[1, 0], in_slave - lasers[1, 1]
    from_master = point - [0.01, 0.002, -0.004]
    p = found.R.T @ (from_master - found.t_m)
    assert np.arctan2(p[1], p[0]) == pytest.approx(np.arctan2(axis0[1], axis0[0]), abs=1e-12)
    assert np.arctan2(p[2], p[0]) == pytest.approx(np.arctan2(axis1[2], axis1[0]), abs=1e-12)


def test_pose_files(tmp_path):
    q = Rotation.from_matrix(TRUE).as_quat().tolist()
    mm = (1e3 * T).tolist()
    for entries in (
        {},
        {"R": None, "quaternion_xyzw": q, "t_m": None, "translation_mm": mm},
        {"t_m": None, "t": T.tolist(), "stations": None, "master": "0xb", "slave": {"id": 12}},
    ):
        found = ref.pose_reference(pose_file(tmp_path, **entries))
        np.testing.assert_allclose(found.R, TRUE, atol=1e-9)
        np.testing.assert_allclose(found.t_m, T, atol=1e-12)
        assert found.ids == (11, 12)
    diagonal = pose_file(tmp_path, t_m=[10, 10, 2])  # of the largest room, 10 m x 10 m
    assert ref.pose_reference(diagonal).t_m.tolist() == [10, 10, 2]
    for at_limit in (
        {"R": (1.00099**0.5 * TRUE).tolist(), "t_m": [0, 30.0, 0]},
        {"R": None, "quaternion_xyzw": [0, 0, 0, 1.0099], "t_m": [0, 0, 0.1]},
        {"R": None, "quaternion_xyzw": [0, 0, 0, 0.9901]},
    ):
        ref.pose_reference(pose_file(tmp_path, **at_limit))


@pytest.mark.parametrize(
    ("entries", "match"),
    [
        ({"R": (-TRUE).tolist()}, "mirror image"),
        ({"R": (1.00101**0.5 * TRUE).tolist()}, "R is no rotation"),
        ({"R": [1, 2]}, "expected 3 x 3 finite numbers"),
        ({"R": None}, "no rotation; expected R"),
        ({"R": None, "quaternion_xyzw": [0, 0, 0, 1.0101]}, "has norm 1.01"),
        ({"R": None, "quaternion_xyzw": [0, 0, 0, 0.9899]}, "has norm 0.9899"),
        ({"t_m": (1e3 * T).tolist()}, "is the unit right"),
        ({"t_m": None, "translation_mm": T.tolist()}, "is the unit right"),
        ({"t_m": [50, 0, 0]}, "is the unit right"),  # cm; the least baseline tracked, 0.5 m
        ({"t_m": [0, 30.001, 0]}, "is the unit right"),
        ({"t_m": [0, 0, 0.0999]}, "is the unit right"),  # one housing
        ({"t_m": None}, "no translation"),
        ({"stations": None}, "no station ids"),
        ({"stations": {"master": 11.5, "slave": 12}}, "expected a whole number"),
        ({"stations": {"master": "0x\u0663", "slave": 12}}, "expected a whole number"),
        ({"stations": {"master": "1" * 5000, "slave": 12}}, "id is '1{30}'; expected a whole"),
    ],
)
def test_pose_files_that_are_refused(tmp_path, entries, match):
    with pytest.raises(Refusal, match=match):
        ref.pose_reference(pose_file(tmp_path, **entries))


def test_ids():
    def check(a, b, ids=(11, 12)):
        return ref.check_ids(
            ref.Reference(TRUE, T, ids), [Station("master", a), Station("slave", b)]
        )

    assert check(11, 12) == ""
    with pytest.raises(Refusal, match=r"swapped.*invert the pose"):
        check(12, 11)
    with pytest.raises(Refusal, match="its slave is station 12, that of the recording is 13"):
        check(11, 13)
    assert "unknown for slave of the recording" in check(11, None)
    assert "unknown for master of reference" in check(11, 12, (None, None))


def test_mount_files(tmp_path):
    def written(text):
        path = tmp_path / "mount.csv"
        path.write_text(text)
        return path

    good = "label,x_m,y_m,z_m\nA,0.1,0,0\nB,0,0.1,0\n\nC,0,0,0.1\n"
    mount = ref.read_mount(written(good))
    assert list(mount) == ["A", "B", "C"] and mount["B"].tolist() == [0, 0.1, 0]
    for text, match in (
        (good.replace("0.1", "100"), "is the file in mm"),
        (good.replace("C", "A"), "label A occurs twice"),
        (good.replace("0,0,0.1", "0,0,x"), "line 5"),
        (good.replace("x_m", "x"), "expected label,x_m,y_m,z_m"),
        (good.split("C")[0], "at least three"),
        (good.replace("C", "\0"), "line 5"),
    ):
        with pytest.raises(Refusal, match=match):
            ref.read_mount(written(text))
