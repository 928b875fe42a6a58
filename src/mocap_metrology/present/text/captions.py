"""Words below figures and tables: each name of `captions.toml` is an attribute of this module.
The papers and calibrations have files of their own."""

from __future__ import annotations

import tomllib
from pathlib import Path

FILES = (Path(__file__).with_name(f"{name}.toml") for name in ("captions", "papers", "calibration"))
TEXTS = {k: v for file in FILES for k, v in tomllib.loads(file.read_text(encoding="utf-8")).items()}


def __getattr__(name: str) -> str:
    """A text as one line."""
    if not isinstance(text := TEXTS.get(name), str):
        raise AttributeError(f"captions.toml has no text {name}")
    return " ".join(text.split())


def texts(table: str) -> dict[str, str]:
    """The texts of a table of these files."""
    return {key: " ".join(text.split()) for key, text in TEXTS[table].items()}


def _key(figure: int | str) -> int | str:
    return int(figure) if str(figure).isdecimal() else figure


JANSEN, SKUROWSKI = (
    {_key(figure): text for figure, text in texts(paper).items()}
    for paper in ("JANSEN", "SKUROWSKI")
)
CALIBRATION_EITHER = (
    f"{__getattr__('CALIBRATION')} Where the pose is by batch: {__getattr__('CALIBRATION_BATCH')} "
    f"Otherwise: {__getattr__('CALIBRATION_BOARD_POSES')}"
)


def of_jansen(*figures: int | str) -> str:
    """Captions of several figures one after the other, each with its number."""
    return " ".join(f"Figure {figure}: {JANSEN[_key(figure)]}" for figure in figures)


def of_skurowski(*figures: int | str) -> str:
    """Captions of several figures one after the other, each with its number."""
    return " ".join(f"Figure {figure}: {SKUROWSKI[_key(figure)]}" for figure in figures)
