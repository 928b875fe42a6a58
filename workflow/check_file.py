"""The verdict on one file, without a sheet: `python workflow/check_file.py take.c3d`.

A sheet of one row is written into the folder of results, the workflow runs there for the verdict,
the diagnosis and the Allan deviations, and what it found is printed.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "workflow"))

from mocap_workflow import one_file  # noqa: E402
from mocap_workflow.crashes import crashes, kept  # noqa: E402

FEWEST_SEEN = 0.5  # share of frames a marker must be there in to be chosen
LAST_LINES = 12
CHATTER = ("Using workflow specific profile", "Config file ", "host: ", "Building DAG")


def main(arguments: Sequence[str] | None = None) -> int:
    """Check one file; 0 if there is a verdict, whatever it is, 1 if the file is refused or a step
    crashes, which is said with the place of its traceback."""
    given = _parser().parse_args(arguments)
    path = Path(given.file).expanduser().resolve()
    folder = Path(given.results or f"results/check/{one_file.folder_of(path)}").resolve()
    try:
        return _checked(path, folder, given)
    except Exception as error:
        print(f"{kept(error, folder, f'check of {path.name}')}\nNo verdict", file=sys.stderr)
        return 1


def _checked(path: Path, folder: Path, given: argparse.Namespace) -> int:
    from mocap_metrology.common.errors import Refusal

    try:
        _check_path(path, given.file)
        markers = _markers(path, given)
        cells = {"markers": ";".join(markers), "frame_rate_hz": given.rate}
        cells["truncated"] = "accept" if given.accept_truncated else None
        name = one_file.write_sheet(folder, path, cells)
    except Refusal as refusal:
        print(f"{refusal}{_advice(refusal)}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"{folder}: {error.strerror}; expected a folder to write to", file=sys.stderr)
        return 1
    if _run(folder, name, given.cores):
        return 1
    _tell(folder / "recordings" / name)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="check_file.py",
        description="The verdict on one recording of markers that stand still.",
    )
    parser.add_argument("file", help="the recording: .c3d, .trc, .csv, .tsv, .txt")
    parser.add_argument(
        "--markers",
        metavar='"A;B"',
        help="labels of the markers, separated by ; (default: the first two that stand still)",
    )
    parser.add_argument(
        "--accept-truncated",
        action="store_true",
        help="use what is there of a file that is cut off (default: refuse it)",
    )
    parser.add_argument(
        "--rate",
        metavar="HZ",
        help="frames a second, of a file that does not say (default: its own)",
    )
    parser.add_argument("--results", help="folder of the results (default: results/check/<file>)")
    parser.add_argument("--cores", type=_count, default=2, help="processes at once (default: 2)")
    return parser


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r}; expected a whole number, 1 or more")
    return int(text)


def _check_path(path: Path, given: str) -> None:
    from mocap_metrology.common.errors import Refusal

    if not path.exists():
        raise Refusal(f"{given}: no such file; expected a recording, as take.c3d")
    if not path.is_file():
        raise Refusal(f"{given}: is not a file; expected a recording, as take.c3d")
    if any(letter in str(path) for letter in ";\t\n\r"):
        raise Refusal(f"{given}: expected a path without semicolons, tabs and line breaks")


def _advice(refusal: Exception) -> str:
    """What to do about it without a sheet."""
    from mocap_metrology.common.errors import Truncated

    if isinstance(refusal, Truncated):
        return "; to use what is there: make check ... TRUNCATED=accept, or --accept-truncated"
    if "column frame_rate_hz" in str(refusal):
        return ", which is RATE=100 in make check, or --rate 100"
    return ""


def _markers(path: Path, given: argparse.Namespace) -> list[str]:
    """Those asked for if the file has them, else a choice, which is told."""
    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.io.read import labels_of

    labels = labels_of(path)
    stripped = [label.strip() for label in labels]
    wanted = [part.strip() for part in (given.markers or "").split(";") if part.strip()]
    missing = [name for name in wanted if name not in (*stripped, *one_file.numbered(labels))]
    if missing:
        raise Refusal(
            f"{path.name}: no marker {', '.join(missing)}; expected some of: "
            f"{one_file.listed(labels)}"
        )
    if wanted:
        return wanted
    chosen, why = one_file.choose(labels, lambda label: _movement(path, label, given), _still_mm())
    if not chosen:
        stars = [label for label in stripped if label.startswith("*")]
        name_them = f'; name them: MARKERS="{";".join(stars[:2])}"' if len(stars) > 1 else ""
        raise Refusal(
            f"{path.name}: no labelled marker is seen in half of the frames; expected one among: "
            f"{one_file.listed(labels)}{name_them}"
        )
    print(f'Markers: {", ".join(chosen)} ({why}). Name others with MARKERS="A;B" or --markers:')
    print(f"  {one_file.listed(labels)}")
    return chosen


def _movement(path: Path, label: str, given: argparse.Namespace) -> float | None:
    """Range of a marker's one-second medians in mm; None if it is hardly seen."""
    import numpy as np

    from mocap_metrology.common.errors import Unseen
    from mocap_metrology.io.read import read_recording
    from mocap_metrology.noise.gaussian.two_markers import median_drift

    try:
        found = read_recording([path], [label], _rate(given), False, given.accept_truncated)
    except Unseen:
        return None
    position = found.position_mm[0].astype(float)
    if np.isfinite(position).all(axis=0).mean() < FEWEST_SEEN:
        return None
    ranges = [median_drift(axis, found.frame_rate_hz).range for axis in position]
    return float(max(ranges)) if np.isfinite(ranges).all() else None


def _rate(given: argparse.Namespace) -> float | None:
    from mocap_metrology.common.errors import Refusal

    try:
        return None if not given.rate else float(given.rate)
    except ValueError:
        raise Refusal(f"rate {given.rate!r}; expected frames a second, as 100") from None


def _still_mm() -> float:
    """`still.range_mm` of the project's configuration."""
    import yaml

    document = yaml.safe_load((ROOT / "config/config.yaml").read_text(encoding="utf-8"))
    return float(document["still"]["range_mm"])


def _run(folder: Path, name: str, cores: int) -> int:
    """Run the workflow in the folder; say why where there is no verdict."""
    own = folder / "recordings" / name
    files = ("verdict.json", "diagnosis.json", "adev.png")
    command = [sys.executable, str(ROOT / "workflow/run.py"), "-s", str(ROOT / "Snakefile")]
    command += ["--workflow-profile", str(ROOT / "profiles/ci"), "--cores", str(cores)]
    command += [str(own / file) for file in files]
    command += ["--config", f"recordings={folder / 'check.tsv'}", "calibrations="]
    command += [f"results={folder}", "noise={estimators: [likelihood]}"]
    unwanted = ("PYTHONDONTWRITEBYTECODE", "PYTHONPATH", "SNAKEMAKE_PROFILE")
    environment = {k: v for k, v in os.environ.items() if k not in unwanted}
    log = folder / "check.log"
    with log.open("w", encoding="utf-8") as stream:
        code = subprocess.run(
            command, cwd=folder, env=environment, stdout=stream, stderr=stream, check=False
        ).returncode
    if code:
        print(_why(folder / "check.tsv", own / "check.json", log), file=sys.stderr)
    return code


def _why(sheet: Path, check: Path, log: Path) -> str:
    """The refusal, unless it is of an earlier sheet; else what crashed, and where its traceback is;
    else the end of what was said."""
    if check.is_file() and check.stat().st_mtime_ns >= sheet.stat().st_mtime_ns:
        found = json.loads(check.read_text(encoding="utf-8"))
        if not found["ok"]:
            return f"refused: {found['why']}"
    said = log.read_text(encoding="utf-8", errors="replace").rstrip()
    lines = [line for line in said.splitlines() if not line.startswith(CHATTER)]
    last = crashes(said) or lines[-LAST_LINES:]
    return "\n".join([*last, f"No verdict; all that was said is in {log}"])


def _tell(folder: Path) -> None:
    from mocap_metrology.present.verdict.words import verdict_lines

    found = json.loads((folder / "verdict.json").read_text(encoding="utf-8"))
    print("\n".join(["", *verdict_lines(found), "", "Pictures:"]))
    for path in sorted(folder.glob("*.png")):
        print(f"  {path}")


if __name__ == "__main__":
    sys.exit(main())
