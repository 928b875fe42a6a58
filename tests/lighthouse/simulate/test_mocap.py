"""Markers on both housings: a superposition by scipy finds the true relative pose."""

import numpy as np
from mocap_workflow.calibration_twins import twin_from_mapping
from scipy.spatial.transform import Rotation

from mocap_metrology.lighthouse.simulate.recording import MOUNT_M, simulate_mounts

TWIN = {
    "seed": 21,
    "setup": "here",
    "master": {"id": 11, "mode": "b"},
    "slave": {"id": 12, "mode": "c", "position_m": [0.4, 2.2, 0.1], "rotation_deg": [8, 3, -40]},
    "motion": {"pattern": "still", "centre_m": [3, 0.8, -0.1]},
}


def recorded(**changes):
    twin = twin_from_mapping({**TWIN, **changes})
    return simulate_mounts(twin, twin.seed)


def relative_pose(recording):
    """R and t of the slave's housing in the master's, from the mean of the frames."""
    poses = []
    for prefix in "MS":
        rows = [k for k, label in enumerate(recording.labels) if label[0] == prefix]
        seen, own = 1e-3 * recording.positions_mm[rows].mean(axis=2), MOUNT_M
        R = Rotation.align_vectors(seen - seen.mean(axis=0), own - own.mean(axis=0))[0].as_matrix()
        poses.append((R, seen.mean(axis=0) - R @ own.mean(axis=0)))
    (Rm, tm), (Rs, ts) = poses
    return Rm.T @ Rs, Rm.T @ (ts - tm)


TRUE_R = Rotation.from_euler("ZYX", [-40, 3, 8], degrees=True)


def test_without_noise_the_true_pose_whatever_the_frame_of_the_system():
    first = [recorded(mocap_noise_mm=0, mocap_frames=2, seed=seed) for seed in (1, 2)]
    for recording in first:
        R, t = relative_pose(recording)
        assert np.allclose(R, TRUE_R.as_matrix(), atol=1e-9)
        assert np.allclose(t, [0.4, 2.2, 0.1], atol=1e-9)
    one, two = (recording.positions_mm[:, :, 0] for recording in first)
    assert np.linalg.norm(one - two, axis=1).min() > 10
    distances = np.linalg.norm(MOUNT_M[:, None] - MOUNT_M, axis=2)[np.triu_indices(5, 1)]
    assert np.diff(np.sort(distances)).min() > 4e-3  # tell the markers apart
    assert distances.min() > 0.07 and distances.max() < 0.2  # a mount on a housing of 8 cm
