"""The steps of a calibration, each once: `sweeps` and `pose`. A rule of the workflow calls one of
them, or for a twin both; so does the command.

`given`: paths of what a user names, called dump, board, factory, reference, mount, earlier,
tracked_with, points; of a twin also truth. Results have the names of `TABLES` in a folder.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

from mocap_metrology.calibration.angle_noise import of_calibration
from mocap_metrology.calibration.decode import Check, Entry, checked, decoded
from mocap_metrology.calibration.files import Paths, write_decoded, write_poses
from mocap_metrology.calibration.tables import DECODED, TABLES, TWIN
from mocap_metrology.calibration.twin import with_sensors, write_twin
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import write_csv, write_json, write_table
from mocap_metrology.common.parallel import Over, in_turn
from mocap_metrology.common.types import Row
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin
from mocap_metrology.settings import Allan, Lighthouse


def sweeps(entry: Entry, given: Paths, settings: Lighthouse, folder: Path) -> Check:
    """Check and decode a recording: check.json and `DECODED`. Raises `Refusal` for one that cannot
    be used; then nothing has been written."""
    check, recording = checked(entry, given, settings)
    write_decoded(entry, recording, settings, _paths(DECODED, folder))
    write_json(folder / "check.json", check)
    return check


def refuse(refusal: Refusal, folder: Path) -> None:
    """check.json of a recording that cannot be used, with the reason; tables without rows."""
    why = {"ok": False, "why": str(refusal), "warnings": [], "notes": []}
    write_json(folder / "check.json", why)
    for name in ("pulses", "inertial", "sweeps"):
        write_table(folder / DECODED[name], {}, why)
    write_json(folder / DECODED["stations"], [])
    write_csv(folder / DECODED["board"], [], ("x_m", "y_m", "z_m"))


def pose(
    entry: Entry,
    given: Paths,
    settings: Lighthouse,
    allan: Allan | None,
    folder: Path,
    over: Over = in_turn,
) -> Row:
    """Calibrate the stations by `DECODED`: `ESTIMATED`, and with `allan` the noise of the angles.
    Returns the contents of pose.json. over: as in `calibrate`."""
    files = _paths(TABLES, folder)
    document = write_poses(entry, settings, {**files, **given}, files, over)
    if allan is None:
        Path(files["allan"]).unlink(missing_ok=True)  # of an earlier twin of this name
    else:
        of_calibration(files["allan"], files["sweeps"], files["pose"], allan)
    return document


def simulate(
    entry: Entry,
    twin: LighthouseTwin,
    seed: int,
    given: Paths,
    settings: Lighthouse,
    allan: Allan | None,
    folder: Path,
) -> Row:
    """Simulate a twin as a dump, which is removed in the end, and take both steps with it: `TWIN`,
    `DECODED`, `ESTIMATED`. Returns the contents of pose.json."""
    made = _paths(TWIN, folder)
    with tempfile.TemporaryDirectory(dir=folder, prefix=".part-") as part:
        dump = str(Path(part) / "twin.dump")
        write_twin(twin, seed, made | {"dump": dump})
        board = {"dump": dump, "board": made["twin_board"]}
        recording = with_sensors(decoded(entry, board, settings), twin, seed)
        write_decoded(entry, recording, settings, _paths(DECODED, folder))
    more: dict[str, str] = {"truth": made["truth"]}
    if "reference" not in given and twin.reference == "mocap":
        more |= {"reference": made["reference"], "mount": made["mount"]}
    elif "reference" not in given:
        more["reference"] = made["truth"]
    return pose(entry, {**more, **given}, settings, allan, folder)


def _paths(names: Mapping[str, str], folder: Path) -> dict[str, str]:
    return {name: str(folder / file) for name, file in names.items()}
