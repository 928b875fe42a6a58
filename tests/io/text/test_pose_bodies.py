"""Several bodies in one text of poses, as matrices and as quaternions of either order."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.read import bodies_of, orientation_of, read_recording

N = 300


@pytest.fixture
def poses() -> tuple[np.ndarray, Rotation]:
    """Positions (2, n, 3) in m, and turns of the second body."""
    rng = np.random.default_rng(1)
    return 1 + rng.random((2, N, 3)), Rotation.random(N, rng=rng)


def write(path: Path, comment: str, parts: list[np.ndarray]) -> Path:
    np.savetxt(path, np.hstack(parts), header=comment, fmt="%.9f")
    return path


def matrices(position: np.ndarray, turn: Rotation) -> np.ndarray:
    return np.concatenate([turn.as_matrix(), position[:, :, None]], axis=2).reshape(N, 12)


def test_two_bodies_by_matrices(tmp_path: Path, poses) -> None:
    (a, b), turn = poses
    still = Rotation.identity(N)
    path = write(tmp_path / "bar.txt", "Freq: 100 bodies: left;right",
                 [matrices(a, still), matrices(b, turn)])  # fmt: skip
    assert bodies_of(path) == ("left", "right")
    found = read_recording([path], ["right", "left"])
    assert found.frame_rate_hz == 100
    assert found.position_mm == pytest.approx(1000 * np.array([b.T, a.T]), abs=1e-5)
    back = Rotation.from_quat(orientation_of([path], "right").T)
    assert (back * turn.inv()).magnitude().max() < 1e-7
    one = write(tmp_path / "one.txt", "Freq: 100", [matrices(a, turn)])
    assert bodies_of(one) == ("tracker",)


@pytest.mark.parametrize("order", ["wxyz", "xyzw"])
def test_two_bodies_by_quaternions(tmp_path: Path, poses, order: str) -> None:
    (a, b), turn = poses
    quaternion = turn.as_quat(scalar_first=order == "wxyz")
    comment = f"bodies: A;B\nquaternion: {order}\nFreq: 250"
    path = write(tmp_path / "bar.txt", comment, [a, quaternion, b, quaternion])
    assert read_recording([path], ["B"]).position_mm[0] == pytest.approx(1000 * b.T, abs=1e-5)
    back = Rotation.from_quat(orientation_of([path], "A").T)
    assert (back * turn.inv()).magnitude().max() < 1e-7


@pytest.mark.parametrize(
    ("comment", "words"),
    [
        ("Freq: 9 bodies: A;B", "12 numbers a line; expected 12 for each of A, B"),
        ("bodies: A;A", "bodies: A;A; expected names, none repeated"),
    ],
)
def test_other_numbers_are_refused(tmp_path: Path, poses, comment: str, words: str) -> None:
    (a, _), turn = poses
    path = write(tmp_path / "bar.txt", comment, [matrices(a, turn)])
    with pytest.raises(Refusal, match=r"bar\.txt") as refused:
        read_recording([path], ["A"])
    assert words in str(refused.value)
