"""Sentences on a recording: the templates of recording.toml, filled with their numbers."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any, Literal

from mocap_metrology.present.text import numbers

if TYPE_CHECKING:
    from jinja2 import Environment, Template


@dataclass(frozen=True)
class Sentence:
    """A sentence of the diagnosis. kind: table of its template in recording.toml; severity: info,
    or warning; series: of which it is; words: the sentence; numbers: those in it, units in their
    names."""

    kind: str
    severity: Literal["info", "warning"]
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
    """The sentence of a template `kind.case` with these values, a warning if it matters."""
    names = tuple(series)
    words = render(key, **{"names": names, **(numbers or {}), **values})
    severity: Literal["info", "warning"] = "warning" if matters else "info"
    return Sentence(key.partition(".")[0], severity, names, words, numbers or {})


def render(key: str, **values: Any) -> str:
    """The text of a template `kind.case` with these values."""
    return _template(key).render(values)


@cache
def _template(key: str) -> Template:
    kind, case = key.split(".")
    return _environment().from_string(_texts()[kind][case])


@cache
def _texts() -> Mapping[str, Mapping[str, Any]]:
    path = resources.files("mocap_metrology.present.text") / "recording.toml"
    return tomllib.loads(path.read_text(encoding="utf-8"))


@cache
def _environment() -> Environment:
    """Templates with the number formats of the project as filters."""
    from jinja2 import Environment, StrictUndefined

    made = Environment(undefined=StrictUndefined)
    made.tests["finite"] = math.isfinite
    made.filters |= {
        "at_most": numbers.at_most,
        "duration": numbers.duration_words,
        "fixed": _fixed,
        "g": _general,
        "interval": numbers.with_interval,
        "mm": numbers.mm,
        "moment": numbers.moment,
        "number": numbers.number,
        "percent": numbers.percent,
        "span_percent": _span_percent,
        "unit": numbers.with_unit,
        "upper_first": _upper_first,
    }
    return made


def _fixed(value: float, decimals: int) -> str:
    return f"{value:.{decimals}f}"


def _general(value: float, digits: int = 6) -> str:
    return f"{value:.{digits}g}"


def _span_percent(shares: Iterable[float]) -> str:
    return numbers.span(shares, numbers.percent)


def _upper_first(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}"
