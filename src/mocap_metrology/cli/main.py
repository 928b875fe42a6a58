"""`mocap-metrology check take.c3d`: the verdict on one file, without a sheet.

What is heavy is imported after the first line is on the terminal.
"""

from __future__ import annotations

import argparse
import gc
import os
import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path

EXAMPLES = """examples:
  mocap-metrology check take.c3d
  mocap-metrology check take.c3d --markers LTOE RTOE
  mocap-metrology check poses.txt --rate 100 --unit m
  mocap-metrology check tum.txt --columns "t x y z qx qy qz qw" --unit m --markers tracker
  mocap-metrology check dump.bin --board board.csv
  mocap-metrology check recordings/ more.trc

A recording has markers at rest, for a minute or better an hour: C3D, TRC, CSV of Motive, Vicon
Nexus or First Principles, TSV of Qualisys, N3D, or columns with names (markers, poses). With
--board the file is a sweep dump of a board of photodiodes before two Lighthouse base stations. The
results of an earlier check in the same folder are replaced. Of several files, or of all
recordings in a folder, a table follows in the end. Exit status: 0 if every file has a verdict,
whatever it is; 1 if one has none, the others being checked; 2 for wrong options."""
THREADS = ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "VECLIB_MAXIMUM", "NUMBA")
FORMATS = ("gpio-dump", "libsurvive-rec", "angles-csv")
WORLDS = ("gravity", "master", "board-start")
DUMPS = (".bin", ".dump", ".rec", ".gz")
INTERRUPTED = 130  # the shell's number for it


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status of the command."""
    given = parser().parse_args(arguments)
    check_options(given)
    # One thread a library, as in the workflow: the digits of a sum depend on it
    os.environ.update({f"{pool}_NUM_THREADS": "1" for pool in THREADS})
    try:
        return check(given)
    except KeyboardInterrupt:
        print("\nInterrupted; no results were written", file=sys.stderr, flush=True)
        os._exit(INTERRUPTED)  # threads would finish their series first


def parser() -> argparse.ArgumentParser:
    """The command line."""
    whole = argparse.ArgumentParser(
        prog="mocap-metrology",
        description="How precise is an optical tracking system, and what disturbs it? The answer "
        "comes from its own recordings.",
    )
    whole.add_argument("--version", action=Version, nargs=0, help="print the version and exit")
    commands = whole.add_subparsers(required=True, metavar="command")
    one = commands.add_parser(
        "check",
        help="the verdict on one file",
        description="The verdict on one file: how uncertain its positions are, of what noise, and "
        "whether the system is good enough as a reference.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    one.add_argument(
        "files",
        nargs="+",
        metavar="file",
        help="a recording (.c3d .trc .csv .tsv .txt .n3d), or a dump with --board",
    )
    one.add_argument(
        "--output",
        metavar="DIR",
        help="folder of the results (default: results/check/FILE); of several files one in it each",
    )
    one.add_argument(
        "--threads", type=_count, metavar="N", help="series at once (default: all processors)"
    )
    markers = one.add_argument_group("recordings of markers")
    markers.add_argument(
        "--markers",
        nargs="+",
        default=(),
        metavar="LABEL",
        help='two markers or more at rest, as A B or "A;B" (default: the first two that do)',
    )
    markers.add_argument(
        "--rate",
        type=_rate,
        metavar="HZ",
        help="frames a second, where the file has none or not exactly (default: as in the file)",
    )
    markers.add_argument(
        "--unit",
        choices=("mm", "m"),
        help="unit of the coordinates, where the file names none or a wrong one",
    )
    markers.add_argument(
        "--columns",
        metavar="NAMES",
        help='names of the columns of a table without such, as "t x y z qx qy qz qw"',
    )
    markers.add_argument(
        "--accept-truncated",
        action="store_true",
        help="use what there is of a file that is cut off (default: refuse it)",
    )
    dumps = one.add_argument_group("recordings of a board of photodiodes")
    dumps.add_argument(
        "--board",
        metavar="CSV",
        help="places of the photodiodes: x_m,y_m,z_m in diode order; of a libsurvive recording the "
        "name of the tracked object in it",
    )
    dumps.add_argument(
        "--format",
        choices=FORMATS,
        help="of the dump (default: .rec and .rec.gz libsurvive-rec, .csv angles-csv, all other "
        "gpio-dump)",
    )
    dumps.add_argument(
        "--inertial",
        action="store_true",
        help="use the gyroscope and the accelerometer of a libsurvive recording, too",
    )
    dumps.add_argument(
        "--world",
        choices=WORLDS,
        help="frame of the exported poses of the base stations (default: gravity)",
    )
    dumps.add_argument(
        "--world-points",
        metavar="CSV",
        help="places measured in the room, whose frame is then used: label,x_m,y_m,z_m of master, "
        "slave, diode 3 (at the start), diode 3 at 12.5 s",
    )
    dumps.add_argument(
        "--known-length",
        metavar="LENGTH",
        help='a length in the room, which shows the scale: "stations 4.330 0.005" (m, standard '
        'deviation), "diode 0 at 2.0 s - diode 0 at 7.0 s 2.000 0.002", or "points"',
    )
    dumps.add_argument(
        "--factory",
        metavar="FILE",
        help="factory values of stations whose own cannot be read: stations.json, libsurvive's "
        ".json or a Crazyflie's .yaml",
    )
    dumps.add_argument(
        "--reference",
        metavar="FILE",
        help="a pose to compare with: JSON, a Crazyflie's .yaml or libsurvive's .json",
    )
    one.set_defaults(brief=False)
    return whole


class Version(argparse.Action):
    """Prints the version of the package, which is looked up only then."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib import metadata

        print(f"mocap-metrology {metadata.version('mocap-metrology')}")
        parser.exit()


OF_DUMPS = ("format", "inertial", "world", "world_points", "known_length", "factory", "reference")
OF_MARKERS = ("markers", "rate", "unit", "columns", "accept_truncated")


def check_options(given: argparse.Namespace) -> None:
    """Refuse options that do not apply to such files (SystemExit 2)."""
    wrong, why = (
        (OF_MARKERS, "is not for a dump (--board)") if given.board else (OF_DUMPS, "needs --board")
    )
    for name in wrong:
        if getattr(given, name):
            parser().error(f"--{name.replace('_', '-')} {why}")


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r}; expected a whole number, 1 or more")
    return int(text)


def _rate(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < 1e6:
        raise argparse.ArgumentTypeError(f"{text!r}; expected frames a second, as 100")
    return value


def check(given: argparse.Namespace) -> int:
    """Check all files; a table of several in the end. 0 if each has a verdict."""
    paths = list(_recordings(given))
    if len(paths) == 1 and Path(given.files[0]).expanduser() == paths[0]:
        return check_file(paths[0], Path(given.output) if given.output else None, given)
    from mocap_metrology.cli.results import folder_of, tell_result

    given.brief = True
    rows, status = [], 0
    for number, path in enumerate(paths, start=1):
        print(f"\n{number}/{len(paths)} {path}", file=sys.stderr, flush=True)
        own = folder_of(path)
        folder = Path(given.output) / own.name if given.output else own
        failed = check_file(path, folder, given)
        status |= failed
        rows.append((path.name, "no verdict" if failed else _word(folder), str(folder)))
    width = [max(len(row[k]) for row in rows) for k in range(2)]
    lines = [f"{name:{width[0]}}  {word:{width[1]}}  {folder}" for name, word, folder in rows]
    tell_result(["", *lines])
    return status


def _recordings(given: argparse.Namespace) -> Iterator[Path]:
    """The files, and those in folders whose suffix is that of a recording, with --board of a
    dump."""
    for text in given.files:
        path = Path(text).expanduser()
        if not path.is_dir():
            yield path
            continue
        inside = sorted(p for p in path.iterdir() if p.suffix.lower() in _suffixes(given))
        if not inside:
            print(f"{text}: no recording in this folder", file=sys.stderr)
        yield from inside or [path]


def _suffixes(given: argparse.Namespace) -> Collection[str]:
    if given.board:
        return DUMPS
    from mocap_metrology.io.read import FORMATS

    return {".c3d", *FORMATS}


def _word(folder: Path) -> str:
    """The verdict in a folder of results."""
    import json

    name = "verdict.json" if (folder / "verdict.json").exists() else "pose.json"
    found = json.loads((folder / name).read_text(encoding="utf-8"))
    return str(found["word"] if "word" in found else found["verdict"]["word"])


def check_file(path: Path, output: Path | None, given: argparse.Namespace) -> int:
    """Check one file; report its faults, or a crash and where its traceback is."""
    from mocap_metrology.common.errors import printable
    from mocap_metrology.common.paths import exists

    if exists(path):
        print(f"{printable(path.name)}: reading", file=sys.stderr, flush=True)
    from mocap_metrology.cli.results import folder_of, kept
    from mocap_metrology.common.errors import Refusal

    folder = (output or folder_of(path)).expanduser()
    try:
        _check_path(path, given)
        _imported(given)(path, folder, given)
        return 0
    except Refusal as refusal:
        print(refusal, file=sys.stderr)
    except Exception as error:
        print(f"{kept(error, folder, path.name)}\nNo results were written", file=sys.stderr)
    return 1


def _imported(given: argparse.Namespace) -> Callable[[Path, Path, argparse.Namespace], None]:
    """The function that checks such a file. All that it imports stays, so it is not searched for
    cycles, neither meanwhile nor later."""
    gc.disable()
    try:
        if given.board:
            from mocap_metrology.cli.calibration import check_calibration as check_one
        else:
            from mocap_metrology.cli.recording import check_recording as check_one
    finally:
        gc.freeze()
        gc.enable()
    return check_one


def _check_path(path: Path, given: argparse.Namespace) -> None:
    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.common.paths import exists, is_file

    if not exists(path):
        raise Refusal(f"{path}: no such file; expected a recording, as take.c3d")
    if not is_file(path):
        raise Refusal(f"{path}: is not a file; expected a recording, as take.c3d")
    if path.suffix.lower() in DUMPS and not given.board:
        raise Refusal(f"{path.name}: a dump needs --board board.csv, the places of its photodiodes")
