"""Paths that no file can have: as Windows writes them, or longer than the system takes; locks."""

from __future__ import annotations

import fcntl
import os
import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

DRIVE = re.compile(r"([A-Za-z]):[\\/]?(.*)", re.DOTALL)


def exists(path: str | Path) -> bool:
    """Whether there is such a file or folder; a name that the system does not take is none."""
    with suppress(OSError):
        return Path(path).exists()
    return False


def is_file(path: str | Path) -> bool:
    """Whether there is such a file."""
    return exists(path) and Path(path).is_file()


def is_folder(path: str | Path) -> bool:
    """Whether there is such a folder."""
    return exists(path) and Path(path).is_dir()


def expanded(path: str | Path) -> Path:
    """A path with the home folder in the place of `~`, where there is one."""
    with suppress(RuntimeError):
        return Path(path).expanduser()
    return Path(path)


def real(path: Path) -> Path:
    """A path without links; itself where links lead nowhere."""
    with suppress(OSError, RuntimeError):
        return path.resolve()
    return path.absolute()


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """One process at a time in a folder, which is made where it is missing; without waiting where
    it is read-only, or its file system has no locks."""
    with ExitStack() as held:
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            opened = os.open(folder, os.O_RDONLY)
            held.callback(os.close, opened)
            fcntl.flock(opened, fcntl.LOCK_EX)
        yield


def is_abandoned(folder: Path) -> bool:
    """Whether no process holds the lock of a folder (`locked`), as far as there are locks."""
    with ExitStack() as held, suppress(OSError):
        opened = os.open(folder, os.O_RDONLY)
        held.callback(os.close, opened)
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return True
    return False


def of_windows(path: str | Path) -> str:
    """How a path of Windows is written in WSL or with slashes; empty for any other."""
    text = str(path)
    drive = DRIVE.fullmatch(text)
    if drive is not None:
        rest = drive[2].replace("\\", "/").strip("/")
        return f"in WSL that is /mnt/{drive[1].lower()}/{rest}"
    slashes = text.replace("\\", "/")
    if slashes != text and exists(slashes):
        return f"with slashes it is {slashes}"
    return ""
