"""Names of the results of a calibration, by step."""

from __future__ import annotations

DECODED = {
    "pulses": "pulses.parquet",
    "inertial": "inertial.parquet",
    "sweeps": "sweeps.parquet",
    "stations": "stations.json",
    "board": "board.csv",
}
ESTIMATED = {
    "pose": "pose.json",
    "poses": "poses.parquet",
    "track": "track.parquet",
    "crazyflie": "crazyflie.yaml",
    "libsurvive": "libsurvive.json",
    "ros2": "ros2_static_transforms.launch.xml",
}
ANGLES = "allan.parquet"
RECEIVER = {"receiver": "receiver.json"}
BAR = {"bar": "bar.json", "bar_rows": "bar.csv"}
TABLES = DECODED | ESTIMATED | {"allan": ANGLES}
TWIN = {
    "truth": "truth.json",
    "twin_board": "twin_board.csv",
    "reference": "twin_reference.c3d",
    "mount": "twin_mount.csv",
}
NETWORK_TWIN = {name: TWIN[name] for name in ("truth", "twin_board")}  # of the second generation
