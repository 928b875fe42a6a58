"""Compile every kernel once: `python -m mocap_metrology.common.warm`, called by `make`."""

from __future__ import annotations

import fcntl
import importlib
import pkgutil

import mocap_metrology
from mocap_metrology.common import compiled


def warm() -> list[str]:
    """Call `warm_up()` of every module of the package that has one; return their names."""
    done = []
    for module in pkgutil.walk_packages(mocap_metrology.__path__, "mocap_metrology."):
        if module.name == __name__:
            continue
        warm_up = getattr(importlib.import_module(module.name), "warm_up", None)
        if warm_up is not None:
            warm_up()
            done.append(module.name)
    return done


def main() -> None:
    """Warm up, one process at a time: numba's cache has no lock of its own."""
    if compiled.CACHE is None:
        return
    with (compiled.CACHE.parent / "warm.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        compiled.prune(compiled.CACHE)
        warm()


if __name__ == "__main__":
    main()
