"""What the scripts of tables of calibrations share: the sheet and the results, side by side."""

from __future__ import annotations

import json
from pathlib import Path


def records_of(rows: list[dict[str, object]], paths: list[str]) -> list[dict[str, object]]:
    """What tables are made of: of each row of the sheet what the rule names, and its pose.json."""
    return [
        {**row, "pose": json.loads(Path(path).read_text(encoding="utf-8"))}
        for row, path in zip(rows, paths, strict=True)
    ]
