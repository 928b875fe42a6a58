"""Words below figures and tables: each name of `captions.toml` is an attribute of this module.
The papers and calibrations have files of their own."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import NamedTuple

FILES = (Path(__file__).with_name(f"{name}.toml") for name in ("captions", "papers", "calibration"))
TEXTS = {k: v for file in FILES for k, v in tomllib.loads(file.read_text(encoding="utf-8")).items()}


class Texts(NamedTuple):
    """What a figure states: its title, at its foot where the data come from, and its caption, or
    what is added to that."""

    title: str
    source: str = ""
    caption: str = ""


def __getattr__(name: str) -> str:
    """A text as one line."""
    if not isinstance(text := TEXTS.get(name), str):
        raise AttributeError(f"captions.toml has no text {name}")
    return " ".join(text.split())


def texts(table: str) -> dict[str, str]:
    """The texts of a table of these files."""
    return {key: " ".join(text.split()) for key, text in TEXTS[table].items()}


PAPERS = texts("PAPERS")
CALIBRATION_EITHER = (
    f"{__getattr__('CALIBRATION')} Where the pose is by batch: {__getattr__('CALIBRATION_BATCH')} "
    f"Otherwise: {__getattr__('CALIBRATION_BOARD_POSES')}"
)


def of_figure(paper: str, figure: int | str, source: str = "", *more: str) -> Texts:
    """Texts of a figure of a paper (`skurowski`, `jansen`); more: what is added to its caption."""
    caption = texts(paper.upper())[str(figure)]
    title = f"{PAPERS[paper]}, {label(paper, figure, 0)}"
    return Texts(title, source, " ".join(filter(None, (caption, *more))))


def label(paper: str, figure: int | str, width: int = 2) -> str:
    """`Figure  7: a seismic crump`."""
    number = str(figure).lstrip("0")
    return f"Figure {number:>{width}}: {texts(f'{paper.upper()}_TITLES')[number]}"


def of_figures(paper: str, *figures: int | str) -> str:
    """Captions of several figures one after the other, each with its number."""
    of, numbers = texts(paper.upper()), [str(figure).lstrip("0") for figure in figures]
    return " ".join(f"Figure {number}: {of[number]}" for number in numbers)
