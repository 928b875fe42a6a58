"""Where the recordings by other people are that the tests read (`config/samples.tsv`)."""

import os
from functools import cache
from pathlib import Path

from fetch_samples import ROOT, read_samples

HOW = "`make samples` fetches them, or MOCAP_SAMPLES=folder names a folder that has them"


def places() -> list[Path]:
    """The folder named by the environment; otherwise one beside the project, then one in it."""
    named = os.environ.get("MOCAP_SAMPLES")
    return [Path(named)] if named else [ROOT.parent / "shared/data", ROOT / "samples"]


@cache
def samples_folder() -> Path | None:
    """The first place that holds every sample file, or None."""
    files = [sample.file for sample in read_samples()]
    return next((p for p in places() if all((p / file).is_file() for file in files)), None)
