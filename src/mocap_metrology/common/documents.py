"""YAML and JSON that a user writes: what is ambiguous or would fill the memory is no value.

PyYAML and json take the last of two equal keys, and write out aliases of aliases.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mocap_metrology.common.errors import Refusal

if TYPE_CHECKING:
    import yaml

MOST = 1_000_000  # values of a YAML document, aliases written out
LONGEST = 1000  # digits of a whole number
DEEPEST = 100  # lists and mappings in each other; the loader in C crashes at some thousands


def text_of(path: str | Path, expected: str) -> str:
    """Text of a file in UTF-8. `Refusal` where it cannot be read, with what was expected."""
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        name = Path(path).name
        raise Refusal(f"{name}: cannot be read ({error}); expected {expected}") from None


def load_json(text: str) -> Any:
    """The value of a JSON text. ValueError says what is wrong with it."""
    try:
        return json.loads(text, object_pairs_hook=_with_unique_keys, parse_int=_whole_number)
    except RecursionError:
        raise ValueError("nested too deeply") from None


def _with_unique_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    _expect_once((key, "") for key, _ in pairs)
    return dict(pairs)


def _expect_once(keys: Iterable[tuple[str, str]]) -> None:
    """Each key with its place in words."""
    seen = set()
    for key, where in keys:
        if key in seen:
            raise ValueError(f"{where}key {key} is repeated; expected once")
        seen.add(key)


def _whole_number(digits: str, where: str = "") -> int:
    if len(digits) > LONGEST:
        raise ValueError(f"{where}a number of {len(digits)} digits; expected at most {LONGEST}")
    return int(digits)


def load_yaml(text: str) -> Any:
    """The value of a YAML text. ValueError says what is wrong with it."""
    import yaml

    kind = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # of 20 kB: 0.05 s or 0.4 s
    if (at := text.find("\ufeff", 1)) > 0:  # which the one reads and the other does not
        raise ValueError(f"line {text.count(chr(10), 0, at) + 1}: a byte order mark in the text")
    try:
        if "\t" in text:  # of which the one reads some and the other none
            _expect_shallow(yaml.parse(text, yaml.SafeLoader))
        _expect_shallow(yaml.parse(text, kind))
        loader = kind(text)
        node = loader.get_single_node()
        if node is not None:
            _size(node, {})
        return loader.construct_document(node) if node is not None else None
    except yaml.YAMLError as error:
        raise ValueError(" ".join(str(error).split())) from None


def _expect_shallow(events: Iterable[yaml.Event]) -> None:
    depth = 0
    for event in events:
        kind = type(event).__name__
        depth += kind.endswith("StartEvent") - kind.endswith("EndEvent")
        if depth > DEEPEST:
            raise ValueError(f"{_line(event)}nested {depth} deep; expected at most {DEEPEST}")


def _line(part: yaml.Event | yaml.Node) -> str:
    return f"line {part.start_mark.line + 1}: " if part.start_mark else ""


def _size(node: yaml.Node, known: dict[int, tuple[int, int]]) -> tuple[int, int]:
    """Values in a node and their depth, aliases written out, each node looked at once; ValueError
    where a key occurs twice, or where there are too many values or digits."""
    if id(node) in known:
        return known[id(node)]
    known[id(node)] = MOST, DEEPEST  # where it is an alias within itself
    parts = node.value
    if isinstance(parts, str):
        if node.tag.endswith(":int") and len(parts) > LONGEST:
            _whole_number(parts, _line(node))
        parts = []
    elif parts and isinstance(parts[0], tuple):
        keys = [key for key, _ in parts]
        _expect_once((key.value, _line(key)) for key in keys if isinstance(key.value, str))
        parts = [part for pair in parts for part in pair]
    sizes = [_size(part, known) for part in parts]
    values, depth = 1 + sum(size for size, _ in sizes), 1 + max((d for _, d in sizes), default=0)
    if values > MOST or depth > DEEPEST:
        most = f"{MOST} values, {DEEPEST} deep"
        raise ValueError(f"{_line(node)}too much, as aliases repeat it; expected at most {most}")
    known[id(node)] = values, depth
    return values, depth


def yaml_text(content: object) -> str:
    """YAML with lists of numbers in one line each."""
    import yaml

    return yaml.safe_dump(
        content, sort_keys=False, allow_unicode=True, width=100, default_flow_style=None
    )
