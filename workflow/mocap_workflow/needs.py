"""`mem_mb` and `runtime` of a job, by the size of its recording (measured: docs/scale.md).

They are more at each attempt, where the profile has failed jobs tried again. The size is that of
the files or the length of the twin, and not what a check counted: Snakemake asks for the memory of
a job before the check of its recording is done.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from typing import Any

from mocap_workflow.recording_twins import AnyTwin
from mocap_workflow.recordings import RecordingRow

SLOWEST = 10  # times the measured seconds: processors differ, and others use them too
BYTES_OF_POSITION = 8  # the least: int16 in C3D; a text export has more
Need = Callable[[Any, int], int]  # of the wildcards and the number of the attempt


@dataclass(frozen=True)
class Needs:
    """What jobs of some recordings need."""

    recordings: Mapping[str, RecordingRow]
    twins: Mapping[str, AnyTwin]

    def memory(self, mb: int, arrays: int = 0) -> Need:
        """MB: a base, and so many arrays with a number for each frame of the recording."""

        def of(wildcards: Any, attempt: int) -> int:
            row = self.recordings[wildcards.recording] if arrays else None
            frames = self.positions(row) / _n_markers(row) if row else 0.0
            return attempt * round(mb + 8e-6 * arrays * frames)

        return of

    def minutes(self, count: int, seconds: float = 0) -> Need:
        """Minutes: a base, and seconds for a million positions, which are frames times markers."""

        def of(wildcards: Any, attempt: int) -> int:
            row = self.recordings[wildcards.recording] if seconds else None
            millions = self.positions(row) / 1e6 if row else 0.0
            return attempt * ceil(count + SLOWEST * seconds * millions / 60)

        return of

    def positions(self, row: RecordingRow) -> float:
        """Frames times markers: those of a twin, or at most those that the files can hold. Of a
        file in S3 the size is unknown and counts as nothing."""
        if row.twin:
            twin = self.twins[row.twin]
            return twin.duration_s * twin.frame_rate_hz * _n_markers(row)
        files = [path for path in map(Path, row.paths) if path.is_file()]
        return sum(path.stat().st_size for path in files) / BYTES_OF_POSITION


def _n_markers(row: RecordingRow) -> int:
    """Markers that the sheet names, at least one; a twin has two."""
    return 2 if row.twin else max(len(row.markers), 1)
