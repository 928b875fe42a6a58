"""`mocap-metrology check` of a recording of a board of photodiodes."""

from __future__ import annotations

import argparse
import gc
import multiprocessing
import os
import signal
import sys
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from threading import Thread

from mocap_metrology.accuracy.bar import BarEntry
from mocap_metrology.calibration.angle_noise import of_calibration
from mocap_metrology.calibration.bar import bar
from mocap_metrology.calibration.exports import FORMATS
from mocap_metrology.calibration.pose import reference_of, write_poses
from mocap_metrology.calibration.receiver import receiver
from mocap_metrology.calibration.sweeps import Entry, checked, write_decoded
from mocap_metrology.calibration.tables import BAR, RECEIVER, TABLES
from mocap_metrology.cli.results import IN_PART, name_of, replaced, tell, tell_result
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import read_table, write_json
from mocap_metrology.common.paths import exists
from mocap_metrology.common.sheets import parts_of
from mocap_metrology.lighthouse.assess.calibration_files import CalibrationFiles, read_calibration
from mocap_metrology.lighthouse.assess.pose_file import is_network
from mocap_metrology.present.accuracy.bar import bar_lines
from mocap_metrology.present.calibration.calibration_figure import calibration_figure
from mocap_metrology.present.calibration.pose_text import all_rows
from mocap_metrology.present.calibration.track_figure import track_figure
from mocap_metrology.present.plot.figure import import_matplotlib, save
from mocap_metrology.settings import Allan, Bar, Lighthouse, PoseEstimator

PICTURES = ("calibration.png", "calibration.svg", "track.png", "track.svg")
ESTIMATORS: tuple[PoseEstimator, ...] = ("batch", "paper-lm")  # the others take seconds


def check_calibration(path: Path, folder: Path, options: argparse.Namespace) -> str:
    """Results of one calibration into the folder, the verdict on the terminal; its word."""
    settings = Lighthouse(
        estimators=ESTIMATORS, world=options.world or "gravity", inertial=options.inertial
    )
    named = {"world_points": "points"} | {o: o for o in ("factory", "reference", "receiver")}
    beside = {name: file for o, name in named.items() if (file := getattr(options, o))}
    for option, name in named.items():
        if name in beside and not exists(beside[name]):
            option = option.replace("_", "-")
            raise Refusal(f"{beside[name]}: no such file; expected that of --{option}")
    if str(options.reference).lower().endswith(".c3d"):
        why = "markers on housings need a mount: use a row of a sheet"
        raise Refusal(f"{options.reference}: {why}")
    kind = options.format or format_of(path)
    length = options.known_length
    entry = Entry(name_of(path), str(path.resolve()), kind, options.board, known_length=length)
    with drawing_process() as second:
        tell("1/3 pulses, base stations, sweeps")
        check, decoded = checked(
            entry, {"dump": str(path), "board": options.board} | beside, settings
        )
        for words in (*check["notes"], *check["warnings"]):
            tell(words)
        generation = 2 if check.get("generation") == 2 else 1
        reference_of(entry, options.reference, None, generation)  # refused before the poses
        names = ("check.json", *TABLES.values(), *BAR.values(), *RECEIVER.values(), *PICTURES)
        # The second process ends first, also after a failure: it would create the folder again
        with replaced(folder, names) as part, second:
            files = {name: str(part / file) for name, file in TABLES.items()}
            write_json(part / "check.json", check)
            write_decoded(entry, decoded, settings, files)
            tell("2/3 poses of the board and of the base stations")
            with ThreadPoolExecutor(options.threads) as pool:
                write_poses(entry, settings, files | beside, files, pool.map)
            of_calibration(files["allan"], files["sweeps"], files["pose"], Allan())
            results = read_calibration(files, entry.calibration, None)
            for words in _notes(results):
                tell(words)
            tell_result(_verdict_lines(results, options.brief))
            inputs = files | beside | {"dump": str(path)}
            refusals = list(_tell_truth(entry, inputs, settings, part, options))
            tell("3/3 figures")
            drawn = second.submit(_draw_calibration, files, entry.calibration, part / PICTURES[0])
            tracked = *read_table(files["track"]), *read_table(files["allan"])
            save(track_figure(entry.calibration, None, *tracked), part / PICTURES[2])
            drawn.result()
    if not options.brief:
        exports = f"Exported: {', '.join(TABLES[name] for name in FORMATS)}"
        world = results.pose["world"]
        frame = f"Frame of these: {world['frame']}" if world["name"] else "No poses in these"
        frame += f" ({world['why']})" if world.get("why") else ""
        tell_result(["", exports, frame, f"Figure: {folder / PICTURES[0]}"])
    for refusal in refusals:
        tell(refusal)
    return str(results.pose["verdict"]["word"]) + (IN_PART if refusals else "")


def drawing_process() -> ProcessPoolExecutor:
    """A process that imports matplotlib at once and draws one figure while this one draws another;
    copied from this one where libraries of the system survive that."""
    how = multiprocessing.get_context("fork" if sys.platform == "linux" else "spawn")
    process = ProcessPoolExecutor(1, how, _begin)
    process.submit(import_matplotlib)
    return process


def _begin() -> None:
    gc.disable()  # this process ends soon
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that waits
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _draw_calibration(files: Mapping[str, str], name: str, picture: Path) -> None:
    save(calibration_figure(read_calibration(files, name, None)), picture)


def _verdict_lines(results: CalibrationFiles, brief: bool) -> list[str]:
    """The word and its reason, in brief as one line, else with the pose and its uncertainty."""
    verdict = results.pose["verdict"]
    lines = [f"{results.name}: {verdict['word']}", verdict["reason"]]
    if brief or results.chosen is None:
        return [": ".join(lines)] if brief else lines
    rows, title = all_rows(results), "Pose of the slave in the frame of the master:"
    if is_network(results.pose):
        title = f"Poses of the stations in the frame of station {results.reference_name}:"
    width = max(len(label) for label, _ in rows)
    table = [f"  {label:{width}}  {'  '.join(f'{c:>10}' for c in cells)}" for label, cells in rows]
    return [*lines, "", title, *table]


def _notes(results: CalibrationFiles) -> list[str]:
    """What the chosen estimates left out, and why, each once."""
    chosen = [pose for pose in results.entries.values() if pose is not None]
    mine, every = (
        {f"{pose['estimator']}, {pose['optics']}: " for pose in poses}
        for poses in (chosen, results.pose["poses"])
    )
    told = str(results.pose["verdict"]["reason"])
    notes = [*results.pose["diagnostics"]["left_out"], *(pose["note"] for pose in chosen)]
    notes = [words for words in notes if not words.startswith(tuple(every - mine))]
    return [words for words in dict.fromkeys(notes) if words and words not in told]


def _tell_truth(
    entry: Entry,
    inputs: Mapping[str, str],
    settings: Lighthouse,
    folder: Path,
    options: argparse.Namespace,
) -> Iterator[str]:
    """Tells what a bar and motion capture say of the calibration, writes bar.json, bar.csv and
    receiver.json; why one of them says nothing."""
    if options.bar:
        bar_row = BarEntry(options.bar, options.length, options.length_u)
        paths = {name: str(folder / file) for name, file in BAR.items()}
        document = bar(entry, bar_row, inputs, settings, Bar(), paths)
        if "refused" in document:
            yield f"--bar: {document['refused']}"
        else:
            lines = bar_lines(document)
            tell_result([": ".join(lines[:2])] if options.brief else ["", *lines])
    if options.receiver:
        labels = [one for text in options.receiver_labels for one in parts_of(text) if one]
        output = str(folder / RECEIVER["receiver"])
        document = receiver(entry, options.receiver, labels, inputs, settings, output)
        if "refused" in document:
            yield f"--receiver: {document['refused']}"
        else:
            tell_result(
                [str(document["sentence"])] if options.brief else ["", str(document["sentence"])]
            )


def format_of(path: Path) -> str:
    """The format of a recording by its suffix."""
    name = path.name.lower()
    if name.endswith((".rec", ".rec.gz")):
        return "libsurvive-rec"
    return "angles-csv" if name.endswith(".csv") else "gpio-dump"
