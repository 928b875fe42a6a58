"""Paths as Windows writes them, which mean nothing here."""

from __future__ import annotations

import re
from pathlib import Path

DRIVE = re.compile(r"([A-Za-z]):[\\/]?(.*)", re.DOTALL)


def of_windows(path: str | Path) -> str:
    """How a path of Windows is written in WSL or with slashes; empty for any other."""
    text = str(path)
    drive = DRIVE.fullmatch(text)
    if drive is not None:
        rest = drive[2].replace("\\", "/").strip("/")
        return f"in WSL that is /mnt/{drive[1].lower()}/{rest}"
    slashes = text.replace("\\", "/")
    if slashes != text and Path(slashes).exists():
        return f"with slashes it is {slashes}"
    return ""
