"""A laboratory's recordings and calibrations, good and bad, and the sheets that list them."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml
from mocap_workflow.calibration_twins import calibration_twin
from running import write_sheet

from mocap_metrology.common.files import sha256, write_json
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.lighthouse.assess.pose_file import pose_json
from mocap_metrology.lighthouse.assess.validation import Verdict
from mocap_metrology.lighthouse.decode.factory_file import stations_to_json
from mocap_metrology.lighthouse.records import PoseEstimate, Pulses
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.simulate.recording import (
    SimulatedSweeps,
    simulate,
    simulate_mounts,
    truth_json,
    write_dump,
    write_mounts,
)

HEADER = [
    *("calibration", "setup", "group", "path", "format", "board", "factory", "sha256"),
    *("reference", "reference_labels_master", "reference_labels_slave", "mount", "check_against"),
    "tracked_with",
    "world_points",
    "known_length",
]
WHOLE_S, SHORT_S = 4.0, 2.5  # with and without a whole calibration frame in the flashes
BRIEF_S = 1.0
ROOM = from_angles(0.3, -0.2, 2.0), np.array([5.0, -1.0, 2.2])  # the master in it
SHIFT_MM = 30.0  # of the slave since an earlier calibration
LABELS = {"reference_labels_master": "M1;M2;M3;M4;M5", "reference_labels_slave": "S1;S2;S3;S4;S5"}
TWINS = f"""
factories:
  one: {{phase: [0.026, 0.054], tilt: [-0.003, -0.003], curve: [0.002, -0.0004],
         gibphase: [2.4, -1.1], gibmag: [0.001, -0.009]}}
  two: {{phase: [0.05, 0.024], tilt: [-0.009, 0.001], curve: [-0.004, -0.0015],
         gibphase: [1.9, -0.8], gibmag: [0.011, -0.011]}}
setups:
  room: &room
    reference: mocap
    duration_s: {WHOLE_S}
    common_urad: 20
    independent_urad: 20
    tilt_deg: [6.5, 14]
    master: {{id: 3001, mode: b, factory: one}}
    slave: {{id: 3002, mode: c, factory: two,
             position_m: [1.432, 1.976, -0.236], rotation_deg: [17.25, 2.84, -48]}}
    motion: {{pattern: circle, centre_m: [3.57, -1.04, -0.09], speed_m_s: 0.5, extent_m: 0.4,
              wobble_deg: 9, sway_m: 0.04}}
  alone:
    duration_s: {BRIEF_S}
    master: {{id: 3001, mode: A}}
    motion: {{centre_m: [3.5, 0, 0]}}
twins:
  mounted: {{setup: room, seed: 1}}
  short: {{setup: room, seed: 2, duration_s: {SHORT_S}}}
  brief: {{setup: room, seed: 5, duration_s: {BRIEF_S}}}
  alone: {{setup: alone, seed: 4}}
"""
REFUSED = {  # recording: board, what its line says
    "odd": ("board.csv", "bytes are not a whole number of uint32 words"),
    "one-station": ("board.csv", "flashes of one base station only; expected two"),
    "three-diodes": ("board.csv", "sweeps on 3 diodes; a calibration needs at least 4"),
    "small-board": ("small.csv", "the board has 24 diodes; expected a board in diode order"),
    "other-checksum": ("board.csv", f"expected {'0' * 64}"),
}
BAD_ROWS = ("odd",)  # in the sheet


def made(name: str) -> SimulatedSweeps:
    """A twin of `TWINS`, drawn with a seed of its own."""
    return simulate(calibration_twin(yaml.safe_load(TWINS), name), 77)


def write_board(path: Path, places: np.ndarray) -> None:
    lines = ["x_m,y_m,z_m", *(",".join(map(str, place)) for place in places)]
    path.write_text("\n".join(lines) + "\n")


def some(pulses: Pulses, kept: np.ndarray) -> Pulses:
    columns = {name: getattr(pulses, name)[kept] for name in ("start_s", "length_s", "diode")}
    return replace(pulses, **columns)


def write_laboratory(folder: Path, recording: SimulatedSweeps) -> None:
    """What stands beside a dump: board, markers on both housings, mounts, an earlier pose."""
    seen, truth = simulate_mounts(recording.twin, 77), recording.truth
    frames = np.moveaxis(seen.positions_mm, 2, 0).astype(np.float32)
    write_c3d(folder / "lab.c3d", seen.labels, seen.rate_hz, [frames], len(frames))
    write_mounts(folder / "mount.csv", seen.labels)
    write_json(folder / "truth.json", truth_json(recording))
    stranger = truth_json(recording) | {"stations": {"master": 7, "slave": 8}}
    write_json(folder / "stranger.json", stranger)
    write_json(folder / "stations.json", stations_to_json(truth.stations))
    before = truth.t_m + np.array([1e-3 * SHIFT_MM, 0, 0])
    pose = PoseEstimate("paper-lm", "final", "factory", truth.R, before)
    earlier = pose_json([pose], truth.stations, {"slave": 0}, Verdict("good"))
    write_json(folder / "earlier.json", earlier)
    (R,), (t,) = truth.motion.poses(np.array([2.0]))
    points = {"master": np.zeros(3), "slave": truth.t_m, "diode 5 at 2.0 s": R @ truth.board[5] + t}
    places = {label: ROOM[0] @ place + ROOM[1] for label, place in points.items()}
    lines = ["label,x_m,y_m,z_m", *(",".join(map(str, [k, *p])) for k, p in places.items())]
    (folder / "room.csv").write_text("\n".join(lines) + "\n")


def write_bad(folder: Path, brief: SimulatedSweeps) -> None:
    """The files of `REFUSED`."""
    board, pulses = brief.truth.board, brief.pulses
    write_dump(folder / "brief.dump", pulses)
    write_board(folder / "small.csv", board[:24])
    words = np.fromfile(folder / "brief.dump", "<u4")
    (folder / "odd.dump").write_bytes(words.tobytes()[:-1])
    write_dump(folder / "three-diodes.dump", some(pulses, pulses.diode < 3))
    write_dump(folder / "one-station.dump", made("alone").pulses)


def bad_rows() -> dict[str, dict[str, str]]:
    """Cells of each recording of `REFUSED`, besides those that all rows have."""
    bad = {name: {"path": f"{name}.dump", "board": board} for name, (board, _) in REFUSED.items()}
    bad["other-checksum"] |= {"path": "brief.dump", "sha256": "0" * 64}
    bad["small-board"]["path"] = "brief.dump"
    return bad


def sheet_rows(folder: Path) -> list[dict[str, str]]:
    """The twin, recordings that can be used, and some that cannot."""
    common = {"setup": "room", "group": "lab", "format": "gpio-dump", "board": "board.csv"}
    against = {"reference": "lab.c3d", "mount": "mount.csv", "check_against": "earlier.json"}
    against["world_points"] = "room.csv"
    good = {
        "measured": {"path": "lab.dump", "sha256": sha256(folder / "lab.dump")} | against | LABELS,
        "filed": {"path": "short.dump", "factory": "stations.json", "reference": "truth.json"}
        | {"tracked_with": "measured"},
        "stranger": {
            "path": "brief.dump",
            "factory": "stations.json",
            "reference": "stranger.json",
        },
    }
    bad = {name: cells for name, cells in bad_rows().items() if name in BAD_ROWS}
    twin = common | {"group": "jansen2019", "path": "simulate:mounted", "board": ""}
    good["measured"] |= {"setup": "pair"}
    good["filed"] |= {"setup": "pair"}
    return [{"calibration": "twin"} | twin] + [
        {"calibration": name} | common | {"setup": name} | cells
        for name, cells in (good | bad).items()
    ]


# Recordings

RECORDING = [
    *("recording", "path", "markers", "group", "camera_type", "n_cameras", "frame_rate_hz"),
    *("cluster", "truncated", "comment", "compare_with", "covariate", "date", "monitor"),
]
# In the sheet; what its line says
REFUSED_RECORDINGS = {"cut": 'write "accept" in column truncated of the sheet'}
TABLES_OF_RECORDING = ("trajectories.parquet", "clean.parquet", "outliers.csv")
TABLES_OF_CALIBRATION = (
    *("pulses.parquet", "inertial.parquet", "sweeps.parquet", "stations.json", "board.csv"),
)
# Labels, cells and the name of a file that are more than text to some program
ACTIVE = [
    r"![i](http://127.0.0.1:9/i.png) $\frac{x}$ $\undefined$",
    "<img src=http://127.0.0.1:9/ onerror=alert(1)></script><script>alert(1)</script>",
    "=1+cmd|' /C calc'!A0",
]
ACTIVE_MM, BODY_MM = 0.1, np.array([[0, 0, 0], [100, 0, 0], [0, 100, 0]])  # noise, and places
BESIDE = {"compare_with": "active", "covariate": "room-air.csv"}
BESIDE |= {"date": "2026-03-02", "monitor": "hall"}
ACTIVE_FILE = "[x](javascript:alert(1)) ![i](http:127.0.0.1:9).c3d"
TRC = """PathFileType\t4\t(X/Y/Z)\tcut.trc
DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames
100\t100\t200\t1\tmm\t100\t1\t200
Frame#\tTime\tA\t\t
\t\tX1\tY1\tZ1

"""


def take() -> np.ndarray:
    """Two markers with white noise, a slow wave, outliers, a gap and a jump, at 50 Hz."""
    n, rng = 4000, np.random.default_rng(8)
    position = rng.normal(0, 0.02, (n, 2, 3))
    position += [[100, 200, 300], [400, 250, 900]]
    position[:, 0, 2] += 0.05 * np.sin(2 * np.pi * 1.3 * np.arange(n) / 50)
    position[rng.integers(0, n, 12), 1, 0] += 1.0
    position[1500:1530, 1] = np.nan
    return position.astype(np.float32)


def write_bad_recordings(folder: Path) -> None:
    """The files of `REFUSED_RECORDINGS`."""
    lines = [f"{k + 1}\t{k / 100:.3f}\t1.5\t2.5\t3.{k}" for k in range(150)]
    (folder / "cut.trc").write_text(TRC + "\n".join(lines) + "\n")


def write_recordings(folder: Path) -> list[dict[str, str]]:
    """The files of all recordings, and a row for each."""
    position = take()
    write_c3d(folder / "take.c3d", ["A", "B"], 50.0, [position], len(position))
    lines = [f"{t},{20 + np.sin(t / 5):.4f}" for t in range(81)]
    (folder / "room-air.csv").write_text("time_s,celsius\n" + "\n".join(lines) + "\n", "utf-8")
    values = np.random.default_rng(1).normal(100, ACTIVE_MM, (1500, len(ACTIVE), 3)) + BODY_MM
    write_c3d(folder / ACTIVE_FILE, ACTIVE, 50.0, [values], len(values))
    write_bad_recordings(folder)
    two = {"markers": "A;B", "group": "check"}
    rows = [
        two | {"recording": "take", "path": "take.c3d"} | BESIDE,
        {"recording": "active", "path": ACTIVE_FILE, "markers": ";".join(ACTIVE), "group": "check"}
        | {"camera_type": ACTIVE[1], "comment": " ".join(ACTIVE), "cluster": ";".join(ACTIVE)},
        {"recording": "T40-10", "path": "simulate:T40-10", "group": "skurowski2019"}
        | {"camera_type": "T40", "n_cameras": "10"},
    ]
    bad = {"comment": ACTIVE[1], "group": "check"}
    return [*rows, bad | {"recording": "cut", "path": "cut.trc", "markers": "A"}]


def write_everything(folder: Path) -> list[str]:
    """All files and both sheets; the settings of a run over them."""
    mounted = made("mounted")
    write_board(folder / "board.csv", mounted.truth.board)
    write_dump(folder / "lab.dump", mounted.pulses)
    write_dump(folder / "short.dump", made("short").pulses)
    write_laboratory(folder, mounted)
    write_bad(folder, made("brief"))
    own = yaml.safe_load((Path(__file__).parents[2] / "config/twins.yaml").read_text())["twins"]
    text = f"{TWINS}  T40-10: {json.dumps(own['T40-10'])}\n"
    (folder / "twins.yaml").write_text(text)
    settings = ["twins=twins.yaml"]
    for name, header, rows in (
        ("recordings", RECORDING, write_recordings(folder)),
        ("calibrations", HEADER, sheet_rows(folder)),
    ):
        sheet = (folder / write_sheet(folder, header, *rows)).rename(folder / f"{name}.tsv")
        settings.append(f"{name}={sheet.name}")
    return settings
