"""Sentences on recordings: the templates of TOML files, filled with their numbers."""

from __future__ import annotations

import inspect
import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mocap_metrology.present.text import numbers as formats

if TYPE_CHECKING:
    from jinja2 import Environment, Template

    from mocap_metrology.noise.motion.movement import Movement

MOST_NAMED = 6
TEMPLATES = ("recording", "monitor", "statement")


@dataclass(frozen=True)
class Sentence:
    """A sentence of the diagnosis. kind: first part of its template's name;
    severity: info, or warning; series: of which it is; words: the sentence; numbers: those in it,
    units in their names."""

    kind: str
    severity: str
    series: tuple[str, ...]
    words: str
    numbers: Mapping[str, object] = field(default_factory=dict)


def sentence(
    key: str,
    matters: bool,
    series: Iterable[str] = (),
    numbers: Mapping[str, object] | None = None,
    **values: Any,
) -> Sentence:
    """The sentence of a template `kind.case`, a warning if it matters. The template is filled with
    the numbers, these values, and the series as `names`."""
    names, numbers = tuple(series), numbers or {}
    words = render(key, **{"names": names, **numbers, **values})
    return Sentence(key.split(".")[0], "warning" if matters else "info", names, words, numbers)


def render(key: str, **values: Any) -> str:
    """The text of a template `kind.case` with these values."""
    return _template(key).render(values)


@cache
def _template(key: str) -> Template:
    kind, case = key.split(".")
    return _environment().from_string(_texts()[kind][case])


@cache
def _texts() -> dict[str, dict[str, str]]:
    folder = Path(__file__).parent
    files = [(folder / f"{name}.toml").read_text(encoding="utf-8") for name in TEMPLATES]
    return {kind: cases for text in files for kind, cases in tomllib.loads(text).items()}


@cache
def _environment() -> Environment:
    from jinja2 import Environment, StrictUndefined

    environment = Environment(undefined=StrictUndefined)
    of_numbers = dict(inspect.getmembers(formats, inspect.isfunction))
    environment.filters |= of_numbers | {"g": lambda value, digits=6: f"{value:.{digits}g}"}
    environment.globals |= of_numbers
    environment.tests["finite"] = math.isfinite
    return environment


def movement_words(moving: Mapping[str, tuple[str, Movement]], within_s: float) -> list[str]:
    """One line that names every moving marker (`most_moving`) and describes the largest movement:
    `shifts by 2.05 mm along x at 312 s`; none without movement."""
    if not moving:
        return []
    label = max(moving, key=lambda name: moving[name][1].size_mm)
    axis, worst = moving[label]
    size = {"size_mm": worst.size_mm, "time_s": worst.time_s, "axis": axis, "label": label}
    named = {"names": list(moving), "most": MOST_NAMED, "within_s": within_s}
    return [render("moving.line", **named, **size)]
