"""`njit`: numba's, with a cache that cannot go stale.

numba's own file cache watches only the file of the function that is called: a compiled helper
edited in another file still runs as old machine code. Here the cache folder is named by the
hash of every source file of the package that imports this decorator, so an edit of any kernel
starts a new one; kernels take constants only from such files. It lies beside the package; where
that cannot be written, in the user's folder of caches; where that cannot either, nothing is cached
and every process compiles for itself. A cache is run as code (numba unpickles it), so one that
others own or may write to is not used.

`python -m mocap_metrology.common.compiled`, called by `make`, compiles every kernel once.
"""

from __future__ import annotations

import fcntl
import hashlib
import importlib
import os
import pkgutil
import shutil
import stat
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Literal, TypedDict, TypeVar, Unpack, overload

import numba

import mocap_metrology

PACKAGE = Path(__file__).resolve().parents[1]


def sources_hash() -> str:
    """Hash of the names and contents of this file and all of the package that import it."""
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for path in sorted(PACKAGE.rglob("*.py")):
        text = path.read_bytes()
        if b"common.compiled import njit" in text:
            digest.update(path.relative_to(PACKAGE).as_posix().encode() + b"\0" + text)
    return digest.hexdigest()[:16]


def _usable(folder: Path) -> bool:
    """Whether the folder can be written by this user and by nobody else; made if it is missing."""
    try:
        folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        if not all(_is_private(path) for path in (folder, folder.parent)):
            return False
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _is_private(folder: Path) -> bool:
    """A folder, and no link to one, of this user that no group and no other may write to."""
    status = folder.lstat()
    others = status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and not others


def _candidates() -> list[Path]:
    """Folders of caches: beside the package, then of the user (XDG Base Directory, macOS)."""
    try:
        home = Path.home()
    except RuntimeError:  # no entry for this uid, as in some containers
        return [PACKAGE / ".compiled"]
    default = home / ("Library/Caches" if sys.platform == "darwin" else ".cache")
    caches = Path(os.environ.get("XDG_CACHE_HOME") or default)
    users = [caches / "mocap-metrology"] if caches.is_absolute() else []
    return [PACKAGE / ".compiled", *users]


def cache_folder() -> Path | None:
    """Folder of the compiled kernels of these sources, or None where no safe one can be written."""
    name = sources_hash()
    return next((c / name for c in _candidates() if _usable(c / name)), None)


def prune(keep: Path | None) -> None:
    """Remove the caches of other states of the sources."""
    if keep is not None:
        for old in keep.parent.iterdir():
            if old != keep and old.is_dir():
                shutil.rmtree(old, ignore_errors=True)


CACHE = cache_folder()
if CACHE is not None:
    numba.config.CACHE_DIR = str(CACHE)  # type: ignore[attr-defined]  # made when numba is imported


F = TypeVar("F", bound=Callable[..., object])  # a compiled function is called as the Python one is


class Options(TypedDict, total=False):
    """Further options of numba."""

    inline: Literal["never", "always"]
    fastmath: bool | set[str]


@overload
def njit(function: F) -> F: ...
@overload
def njit(**options: Unpack[Options]) -> Callable[[F], F]: ...
def njit(function: F | None = None, **options: Unpack[Options]) -> F | Callable[[F], F]:
    """`numba.njit`, cached as described above; the GIL is released.

    Every compiled function of the project goes through here, helpers included. The cache is not an
    option: numba would keep machine code whose helpers have since been edited.
    """
    compiler: Callable[[F], F] = numba.njit(  # type: ignore[assignment]  # it returns a Dispatcher
        cache=CACHE is not None, nogil=True, error_model="numpy", **options
    )
    return compiler if function is None else compiler(function)


def warm() -> list[str]:
    """Call `warm_up()` of every module of the package that has one; return their names."""
    done = []
    for module in pkgutil.walk_packages(mocap_metrology.__path__, "mocap_metrology."):
        warm_up = getattr(importlib.import_module(module.name), "warm_up", None)
        if warm_up is not None:
            warm_up()
            done.append(module.name)
    return done


def main() -> None:
    """Warm up, one process at a time: numba's cache has no lock of its own."""
    if CACHE is None:
        return
    with (CACHE.parent / "warm.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        prune(CACHE)
        warm()


if __name__ == "__main__":
    main()
