"""`mocap-metrology check take.c3d`: the verdict on one file, without a sheet; `mocap-metrology
monitor FOLDER take.c3d`: one take more of a facility that is watched.

What is heavy is imported after the first line is on the terminal.
"""

from __future__ import annotations

import argparse
import gc
import io
import os
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import Any

from mocap_metrology.cli import results
from mocap_metrology.common.errors import Refusal, is_full
from mocap_metrology.common.paths import exists, expanded, is_file, is_folder, real
from mocap_metrology.lighthouse import RECORDING_FORMATS

TEXTS = tomllib.loads(Path(__file__).with_name("help.toml").read_text(encoding="utf-8"))
THREADS = ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "VECLIB_MAXIMUM", "NUMBA")
OF_LIBSURVIVE = (".rec", ".rec.gz")  # which have their objects in them
DUMPS = (".bin", ".dump", *OF_LIBSURVIVE)
INTERRUPTED = 130  # the shell's number for it


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r}; expected a whole number, 1 or more")
    return int(text)


def _number(text: str, expected: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < 1e6:
        raise argparse.ArgumentTypeError(f"{text!r}; expected {expected}")
    return value


_rate = partial(_number, expected="frames a second, as 100")
_length = partial(_number, expected="mm, as 500")


GENERAL: dict[str, dict[str, Any]] = {
    "output": {"metavar": "DIR"},
    "threads": {"type": _count, "metavar": "N"},
}
OF_MARKERS: dict[str, dict[str, Any]] = {
    "markers": {"nargs": "+", "default": (), "metavar": "LABEL"},
    "rate": {"type": _rate, "metavar": "HZ"},
    "unit": {"choices": ("mm", "m")},
    "columns": {"metavar": "NAMES"},
    "accept-truncated": {"action": "store_true"},
}
OF_BARS: dict[str, dict[str, Any]] = {
    "bar": {"metavar": "A-B"},
    "length": {"type": _length, "metavar": "MM"},
    "length-u": {"type": _length, "metavar": "MM"},
}
OF_MONITOR: dict[str, dict[str, Any]] = {
    "date": {"metavar": "DATE"},
    "restart": {"action": "store_true"},
    "monitor": {"metavar": "NAME"},
    "markers": OF_MARKERS["markers"],
    "rate": OF_MARKERS["rate"],
    "unit": OF_MARKERS["unit"],
}
OF_DUMPS: dict[str, dict[str, Any]] = {
    "board": {"metavar": "CSV"},
    "format": {"choices": RECORDING_FORMATS},
    "inertial": {"action": "store_true"},
    "world": {"choices": ("gravity", "master", "board-start")},
    "world-points": {"metavar": "CSV"},
    "known-length": {"metavar": "LENGTH"},
    "factory": {"metavar": "FILE"},
    "reference": {"metavar": "FILE"},
    "receiver": {"metavar": "FILE"},
    "receiver-labels": {"nargs": "+", "default": (), "metavar": "LABEL"},
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status of the command."""
    command = parser()
    options = command.parse_args(arguments)
    if options.run is check:
        for name, why in _misplaced(options):
            if getattr(options, name.replace("-", "_")):
                command.error(f"--{name} {why}")
    # One thread a library, as in the workflow: the digits of a sum depend on it
    os.environ.update({f"{pool}_NUM_THREADS": "1" for pool in THREADS})
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # what its encoding lacks, as a micro sign
            stream.reconfigure(errors="backslashreplace")
    try:
        return int(options.run(options))
    except KeyboardInterrupt:
        print("\nInterrupted; no results were written", file=sys.stderr, flush=True)
        os._exit(INTERRUPTED)  # threads would finish their series first


def _misplaced(options: argparse.Namespace) -> Iterator[tuple[str, str]]:
    """Options that do not go with the others, and why."""
    if options.board:
        yield from ((name, "is not for a dump (--board)") for name in OF_MARKERS)
    else:
        yield from ((name, "needs --board") for name in OF_DUMPS)
    if options.bar:
        yield "markers", "is not for a moving bar (--bar)"
    else:
        yield from ((name, "needs --bar") for name in OF_BARS)
    if not options.length:
        yield "length-u", "needs --length"
    if not options.receiver:
        yield "receiver-labels", "needs --receiver"


def parser() -> argparse.ArgumentParser:
    """The command line."""
    command = argparse.ArgumentParser(prog="mocap-metrology", description=TEXTS["command"])
    version = f"mocap-metrology {metadata.version('mocap-metrology')}"
    text = "print the version and exit"
    command.add_argument("--version", action="version", version=version, help=text)
    commands = command.add_subparsers(required=True, metavar="command")
    one = commands.add_parser(
        "check",
        help="the verdict on one file",
        description=TEXTS["check"],
        epilog=TEXTS["examples"],
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    one.add_argument("files", nargs="+", metavar="file", help=TEXTS["options"]["files"])
    markers = one.add_argument_group("recordings of markers")
    bars = one.add_argument_group("recordings of a bar that is moved")
    dumps = one.add_argument_group("recordings of a board of photodiodes")
    groups = (one, GENERAL), (markers, OF_MARKERS), (bars, OF_BARS), (dumps, OF_DUMPS)
    for group, options in groups:
        for name, how in options.items():
            group.add_argument(f"--{name}", help=TEXTS["options"][name], **how)
    one.set_defaults(run=check)
    other = commands.add_parser(
        "monitor",
        help="one take more of a facility that is watched",
        description=TEXTS["monitor"],
        epilog=TEXTS["monitor_examples"],
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    for name in ("folder", "file"):
        other.add_argument(name, help=TEXTS["of_monitor"][name])
    for name, how in OF_MONITOR.items():
        other.add_argument(f"--{name}", help=TEXTS["of_monitor"][name], **how)
    other.set_defaults(run=watch)
    return command


def watch(options: argparse.Namespace) -> int:
    """Add a take to the folder of a facility; 1 if it was refused."""
    options.markers = [m for text in options.markers for m in text.split(";") if m.strip()]
    folder, name = expanded(options.folder), Path(options.file).name
    results.tell(f"{name}: reading")
    from mocap_metrology.cli.monitor import add_take
    from mocap_metrology.common.faults import Faults

    try:
        results.expect_text(Path(options.file), folder)
        return add_take(options)
    except (Refusal, Faults) as refusal:
        print(refusal, file=sys.stderr)
    except Exception as error:
        crash = results.write_crash(error, folder, name)
        print(f"{crash}\nThe take was not added", file=sys.stderr)
    return 1


def check(options: argparse.Namespace) -> int:
    """Check all files; a table of several in the end. 0 if each has a verdict, and what else was
    asked of it an answer."""
    once: dict[Path, Path] = {}
    for path in _recordings(options):
        once.setdefault(real(path), path)
    paths = list(once.values())
    options.brief = len(paths) > 1 or paths[0] != expanded(options.files[0])
    rows = []
    for number, (path, folder) in enumerate(results.folders_of(paths), start=1):
        if options.brief:
            print(file=sys.stderr)
            results.tell(f"{number}/{len(paths)} {path}")
        if options.output:
            folder = Path(options.output, folder.name if options.brief else "")
        rows.append((path, check_file(path, folder, options), str(folder)))
    if options.brief:
        results.tell_result(["", *_table(rows)])
        if options.bar and not options.board:
            from mocap_metrology.cli.bar import tell_together

            tell_together([Path(folder) for _, word, folder in rows if word != results.NONE])
    return int(any(word.endswith((results.NONE, results.IN_PART)) for _, word, _ in rows))


def _table(rows: Sequence[tuple[Path, str, str]]) -> list[str]:
    """Lines of file, word and folder of results; files of one name with the folder they are in."""
    times = Counter(path.name for path, *_ in rows)
    names = [str(path) if times[path.name] > 1 else path.name for path, *_ in rows]
    width = [max(map(len, of)) for of in (names, [word for _, word, _ in rows])]
    return [
        f"{name:{width[0]}}  {word:{width[1]}}  {folder}"
        for name, (_, word, folder) in zip(names, rows, strict=True)
    ]


def _recordings(options: argparse.Namespace) -> Iterator[Path]:
    """The files, and those in folders whose suffix is that of a recording, with --board of a
    dump."""
    for text in options.files:
        path = expanded(text)
        if not is_folder(path):
            yield path
            continue
        from mocap_metrology.io.read import FORMATS

        endings = DUMPS if options.board else (".c3d", *FORMATS, *OF_LIBSURVIVE)
        inside = sorted(
            p
            for p in path.iterdir()
            if p.name.lower().endswith(endings) and not p.name.startswith(".")  # `._take.c3d`
        )
        if not inside:
            results.tell(f"{text}: no recording in this folder")
        yield from inside or [path]


def check_file(path: Path, folder: Path, options: argparse.Namespace) -> str:
    """The word of the verdict on one file, or that there is none; reports its faults, or a crash
    and where its traceback is."""
    folder = expanded(folder)
    try:
        if not exists(path):
            raise Refusal(f"{path}: no such file; expected a recording, as take.c3d")
        results.tell(f"{path.name}: reading")
        if not is_file(path):
            raise Refusal(f"{path}: is not a file; expected a recording, as take.c3d")
        results.expect_text(path, folder)
        if path.name.lower().endswith(DUMPS) and not options.board:
            options = argparse.Namespace(**vars(options) | {"board": _only_object(path)})
        return _verdict(path, folder, options)
    except Refusal as refusal:
        print(refusal, file=sys.stderr)
    except Exception as error:
        if is_full(error):
            results.tell(f"{folder}: {error.strerror}; no results were written")
        else:
            crash = results.write_crash(error, folder, path.name)
            print(f"{crash}\nNo results were written", file=sys.stderr)
    return results.NONE


def _only_object(path: Path) -> str:
    """The --board of a dump: the one object of a recording of libsurvive."""
    what = "a dump needs --board board.csv, the places of its photodiodes"
    if path.name.lower().endswith(OF_LIBSURVIVE):
        from mocap_metrology.lighthouse.decode.libsurvive import tracked_objects

        names = [one.name for one in tracked_objects(path)]
        if len(names) == 1:
            return names[0]
        what = f"name one of its objects with --board, in make BOARD=: {', '.join(names)}"
        if not names:
            what = "no line `seconds object CONFIG ...`; expected a recording of libsurvive"
    raise Refusal(f"{path.name}: {what}")


def _verdict(path: Path, folder: Path, options: argparse.Namespace) -> str:
    """All that is imported stays, so it is not searched for cycles, neither meanwhile nor later."""
    gc.disable()
    try:
        if options.board:
            from mocap_metrology.cli.calibration import check_calibration as check_one
        elif options.bar:
            from mocap_metrology.cli.bar import check_bar as check_one
        else:
            from mocap_metrology.cli.recording import check_recording as check_one
    finally:
        gc.freeze()
        gc.enable()
    return check_one(path, folder, options)
