"""Fetch the recordings by other people that tests and examples read: `make samples`.

`config/samples.tsv` names each file with its origin, commit, licence and SHA-256. Files are
downloaded from GitHub, or copied from a folder that has them (`make samples FROM=folder`). A file
whose checksum differs is refused.
"""

from __future__ import annotations

import argparse
import csv
import os
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

ROOT = Path(__file__).resolve().parents[1]
SHEET = ROOT / "config/samples.tsv"
ORIGIN = "https://raw.githubusercontent.com"
ADVICE = "a folder that holds the files serves as well: make samples FROM=folder"


@dataclass(frozen=True)
class Sample:
    """One file: where it belongs in the folder of samples, and where it comes from."""

    file: str
    repository: str
    path: str
    commit: str
    licence: str
    sha256: str

    def url(self, origin: str = ORIGIN) -> str:
        """Address of the file under an origin that is laid out like GitHub's."""
        return f"{origin.rstrip('/')}/{quote(f'{self.repository}/{self.commit}/{self.path}')}"


def read_samples(sheet: Path = SHEET) -> list[Sample]:
    """All samples, in the order of the sheet."""
    lines = sheet.read_text(encoding="utf-8").splitlines()
    rows = csv.DictReader((x for x in lines if not x.startswith("#")), delimiter="\t")
    return [Sample(**row) for row in rows]


def fetch(sample: Sample, folder: Path, origin: str, source: Path | None) -> bool:
    """Put one sample into the folder; False if it was there. ValueError: the checksum differs."""
    from pooch import file_hash, get_logger, retrieve

    target = folder / sample.file
    if target.is_file() and file_hash(str(target)) == sample.sha256:
        return False

    def copy(_url: str, output: str, _pooch: object) -> None:
        shutil.copyfile(source / sample.file, output)

    get_logger().setLevel("ERROR")
    retrieve(
        sample.url(origin),
        known_hash=f"sha256:{sample.sha256}",
        fname=target.name,
        path=target.parent,
        downloader=copy if source else None,
    )
    return True


def main(arguments: Sequence[str] | None = None) -> int:
    """Fetch every sample; 0 if all are there."""
    from requests import ConnectionError as NoConnection
    from requests import RequestException

    options = _parser().parse_args(arguments)
    samples = read_samples(options.sheet)
    new, failed = 0, 0
    for sample in samples:
        try:
            new += fetch(sample, options.to, options.origin, options.source)
        except NoConnection:
            print(f"no connection to {options.origin}; {ADVICE}", file=sys.stderr)
            return 1
        except FileNotFoundError:
            failed += 1
            print(f"{sample.file}: not in {options.source}", file=sys.stderr)
        except (ValueError, RequestException) as error:
            failed += 1
            print(f"{sample.file}: {' '.join(str(error).split())}", file=sys.stderr)
    print(
        f"{options.to}: {len(samples) - failed} of {len(samples)} sample files, {new} of them new"
    )
    return 1 if failed else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="fetch_samples.py",
        description="Fetch the recordings by other people that tests and examples read.",
    )
    parser.add_argument("--to", type=Path, default=ROOT / "samples", help="folder (samples)")
    parser.add_argument(
        "--from",
        dest="source",
        type=Path,
        default=Path(os.environ["MOCAP_SAMPLES"]) if os.environ.get("MOCAP_SAMPLES") else None,
        help="folder to copy from instead of the network (default: that of MOCAP_SAMPLES, if set)",
    )
    parser.add_argument("--origin", default=ORIGIN, help="server laid out like %(default)s")
    parser.add_argument("--sheet", type=Path, default=SHEET, help="list of the files")
    return parser


if __name__ == "__main__":
    sys.exit(main())
