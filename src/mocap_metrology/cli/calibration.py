"""`mocap-metrology check` of a recording of a board of photodiodes."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from mocap_metrology.calibration.angle_noise import of_calibration
from mocap_metrology.calibration.decode import Entry, checked
from mocap_metrology.calibration.exports import FORMATS
from mocap_metrology.calibration.files import write_decoded, write_poses
from mocap_metrology.calibration.tables import TABLES
from mocap_metrology.cli.beside import beside
from mocap_metrology.cli.results import name_of, replaced, tell, tell_result
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import read_table, write_json
from mocap_metrology.common.paths import exists
from mocap_metrology.present.calibration.calibration_figure import calibration_figure
from mocap_metrology.present.calibration.calibration_files import CalibrationFiles, read_calibration
from mocap_metrology.present.calibration.pose_text import pose_rows
from mocap_metrology.present.calibration.track_figure import track_figure
from mocap_metrology.present.plot.figure import import_matplotlib, save
from mocap_metrology.settings import Allan, Lighthouse, PoseEstimator

OPTIONS = {"points": "world-points"}
PICTURES = ("calibration.png", "calibration.svg", "track.png", "track.svg")
# Those of the paper are for its tables, and take seconds.
OWN: tuple[PoseEstimator, ...] = ("batch", "paper-lm")


def check_calibration(path: Path, folder: Path, given: argparse.Namespace) -> None:
    """Results of one calibration into the folder, and the verdict on the terminal."""
    kind = given.format or format_of(path)
    settings = Lighthouse(estimators=OWN, world=given.world or "gravity", inertial=given.inertial)
    named = {
        "points": given.world_points, "factory": given.factory, "reference": given.reference
    }  # fmt: skip
    beside_it = {name: file for name, file in named.items() if file}
    for name, file in beside_it.items():
        if not exists(file):
            raise Refusal(f"{file}: no such file; expected that of --{OPTIONS.get(name, name)}")
    if str(given.reference).lower().endswith(".c3d"):
        raise Refusal(f"{given.reference}: markers on housings need a mount: use a row of a sheet")
    length = given.known_length
    entry = Entry(name_of(path), str(path.resolve()), kind, given.board, known_length=length)
    with beside(import_matplotlib, _draw_calibration) as second:
        tell("1/3 pulses, base stations, sweeps")
        check, decoded = checked(
            entry, {"dump": str(path), "board": given.board} | beside_it, settings
        )
        for words in (*check["notes"], *check["warnings"]):
            tell(words)
        with replaced(folder, ("check.json", *TABLES.values(), *PICTURES)) as part:
            files = {name: str(part / file) for name, file in TABLES.items()}
            write_json(part / "check.json", check)
            write_decoded(entry, decoded, settings, files)
            tell("2/3 poses of the board and of the base stations")
            with ThreadPoolExecutor(given.threads) as pool:
                write_poses(entry, settings, files | beside_it, files, pool.map)
            of_calibration(files["allan"], files["sweeps"], files["pose"], Allan())
            found = read_calibration(files, entry.calibration, None)
            lines = _verdict(found)
            tell_result([": ".join(lines[:2])] if given.brief else lines)
            tell("3/3 figures")
            second.call(files, entry.calibration, part / PICTURES[0])
            tracked = read_table(files["track"]), read_table(files["allan"])
            save(
                track_figure(entry.calibration, None, *tracked[0], *tracked[1]), part / PICTURES[2]
            )
            second.wait()
    if given.brief:
        return
    exports = f"Exported: {', '.join(TABLES[name] for name in FORMATS)}"
    world = found.pose["world"]
    frame = f"Frame of these: {world['frame']}" if world["name"] else "No poses in these"
    if world.get("why"):
        frame += f" ({world['why']})"
    tell_result(["", exports, frame, f"Figure: {folder / PICTURES[0]}"])


def _draw_calibration(files: Mapping[str, str], name: str, picture: Path) -> None:
    save(calibration_figure(read_calibration(files, name, None)), picture)


def _verdict(found: CalibrationFiles) -> list[str]:
    """The word, its reason, and the pose with its uncertainty."""
    verdict = found.pose["verdict"]
    lines = [f"{found.name}: {verdict['word']}", verdict["reason"]]
    if found.chosen is None:
        return lines
    rows = pose_rows(found.chosen)
    width = max(len(label) for label, _ in rows)
    table = [
        f"  {label:{width}}  {'  '.join(f'{cell:>10}' for cell in cells)}" for label, cells in rows
    ]
    return [*lines, "", "Pose of the slave in the frame of the master:", *table]


def format_of(path: Path) -> str:
    """By the suffix."""
    name = path.name.lower()
    if name.endswith((".rec", ".rec.gz")):
        return "libsurvive-rec"
    return "angles-csv" if name.endswith(".csv") else "gpio-dump"
