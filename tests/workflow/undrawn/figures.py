"""In place of `recording.figures`: the same files, empty."""

from pathlib import Path


def empty(folder: Path, name: str) -> None:
    for suffix in ("svg", "png"):
        (folder / f"{name}.{suffix}").touch()


def draw_allan(results) -> None:
    empty(results.folder, "adev")


def draw_trajectory(results) -> None:
    empty(results.folder, "trajectory")


def draw_diagnosis(diagnosis, results, settings) -> None:
    empty(results.folder, "diagnosis")


def draw_verdict(document, folder: Path) -> None:
    empty(folder, "verdict")


def draw_fits(results, folder: str, chosen) -> None:
    Path(folder).mkdir(exist_ok=True)


def decisive(document) -> set[str]:
    return set()
