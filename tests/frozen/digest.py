"""A few numbers of every result, which change where the result does."""

import json
import math
import re
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

LONG = 8  # longer lists and columns are summed up
RTOL = 5e-3  # of the rms of what is summed up; other processors and libraries stay within it
NOT_JSON = ("libsurvive.json",)  # lines of several documents
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
UNSTABLE = ("sha256", "versions", "version", "created")
# S's searches share variance between equal components by chance of rounding, and whether a board
# pose has a second minimum at all depends on it: other processors give other numbers.
SEARCHED = ("levenberg-marquardt", "annealing-ant-colony")
BY_ROUNDING = ("ambiguity",)
# The search ends at a step of 0.02 standard deviations, which are large of these; wrong hits at the
# limit of their weight count in one diode or not
WEAK, WEAK_RTOL = ("offset_urad", "state.values", "residual_ratios"), 0.05
Flat = dict[str, Any]


def of_values(values: np.ndarray) -> list[float]:
    """Number of values, of finite ones, their mean, rms, and mean product with a fixed wave, in
    which order and single values show."""
    x = np.asarray(values, float).ravel()
    finite = np.isfinite(x)
    x = np.where(finite, x, 0.0)
    n = max(int(finite.sum()), 1)
    wave = np.cos(0.7 * np.arange(len(x)) + 1.0)
    return [len(x), int(finite.sum()), x.sum() / n, math.sqrt(x @ x / n), x @ wave / math.sqrt(n)]


def is_numbers(values: Any) -> bool:
    return isinstance(values, np.ndarray) and values.dtype.kind in "bfiu"


def of_column(values: Iterable[Any]) -> Any:
    """Short columns are kept whole; of long ones what `of_values` says, or their words."""
    if is_numbers(values) and len(values) > LONG:
        return of_values(values)
    cells = [v.item() if isinstance(v, np.generic) else v for v in values]
    parts = [(v.real, v.imag) if isinstance(v, complex) else (v,) for v in cells]
    cells = [part for both in parts for part in both]
    if all(v is None or isinstance(v, int | float) for v in cells):
        numbers = [math.nan if v is None else float(v) for v in cells]
        return numbers if len(numbers) <= LONG else of_values(np.array(numbers))
    if len(cells) <= LONG:
        return [v if isinstance(v, float) else str(v) for v in cells]
    numbers = [float(v) for v in cells if isinstance(v, float)]
    words = sorted({str(v) for v in cells if not isinstance(v, float)})[:LONG]
    return [len(cells), *words, *(of_values(np.array(numbers)) if numbers else [])]


def flat(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Leaves of a document by their path; numbers of one mapping, and the same key of several
    mappings in a list, are one leaf."""
    if is_dataclass(value):
        value = {k: getattr(value, k) for k in value.__dataclass_fields__}
    if isinstance(value, Mapping):
        numbers = {k: v for k, v in value.items() if isinstance(v, int | float | np.number)}
        if len(numbers) > 2:
            yield f"{name} {zlib.crc32(' '.join(map(str, numbers)).encode())}", [*numbers.values()]
        for key, inner in value.items():
            if key not in UNSTABLE and (len(numbers) <= 2 or key not in numbers):
                yield from flat(inner, f"{name}.{key}" if name else str(key))
    elif is_numbers(value):
        yield name, of_column(np.ravel(value))
    elif isinstance(value, list | tuple | np.ndarray):
        items = np.ravel(value).tolist() if isinstance(value, np.ndarray) else list(value)
        if any(
            isinstance(v, list | tuple | Mapping | np.ndarray) or is_dataclass(v) for v in items
        ):
            joined: dict[str, list[Any]] = {}
            for inner in items:
                for key, leaf in flat(inner):
                    joined.setdefault(key, []).extend(leaf if isinstance(leaf, list) else [leaf])
            yield from ((f"{name}[].{key}", of_column(v)) for key, v in joined.items())
        else:
            yield name, of_column(items)
    else:
        yield name, value.item() if isinstance(value, np.generic) else value


def of_folder(folder: Path) -> Flat:
    """Every table and document in a folder."""
    found: Flat = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.suffix in (".csv", ".parquet"):
            read = pd.read_csv if path.suffix == ".csv" else pd.read_parquet
            table = read(path)
            if "estimator" in table:
                table = table[~table["estimator"].isin(SEARCHED)]
            table = table.drop(columns=[c for c in BY_ROUNDING if c in table])
            found |= {f"{name}: {column}": of_column(table[column].to_numpy()) for column in table}
        elif path.suffix == ".json" and path.name not in NOT_JSON:
            found |= {f"{name}: {key}": v for key, v in flat(json.loads(path.read_text()))}
        elif path.suffix in (".json", ".yaml", ".params", ".xml"):
            text = path.read_text()
            found[f"{name}: words"] = zlib.crc32(NUMBER.sub("#", text).encode())
            found[f"{name}: numbers"] = of_values(np.array(NUMBER.findall(text), float))
    return found


def stored(value: Any) -> Any:
    """As JSON has it, with six digits."""
    if isinstance(value, list):
        return [stored(v) for v in value]
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else str(value)
    return value if isinstance(value, str | int | bool) or value is None else str(value)


def changed(now: Flat, before: Flat) -> list[str]:
    """Lines that say which leaves differ, at most twenty."""
    lines = [f"{key} is new" for key in now if key not in before]
    lines += [f"{key} is missing" for key in before if key not in now]
    for key in now.keys() & before.keys():
        one, other = stored(now[key]), before[key]
        if not same(one, other, WEAK_RTOL if any(name in key for name in WEAK) else RTOL):
            lines.append(f"{key}: {other} -> {one}")
    return sorted(lines)[:20]


def same(one: Any, other: Any, rtol: float = RTOL) -> bool:
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        numbers = [v for v in (*one, *other) if isinstance(v, float)]
        finite = [v for v in numbers if math.isfinite(v)]
        scale = math.sqrt(sum(v * v for v in finite) / max(len(finite), 1))
        return all(close(a, b, rtol, rtol * scale) for a, b in zip(one, other, strict=True))
    return close(one, other, rtol)


def close(one: Any, other: Any, rtol: float, atol: float = 0.0) -> bool:
    if isinstance(one, float) or isinstance(other, float):
        try:
            return math.isclose(float(one), float(other), rel_tol=rtol, abs_tol=atol)
        except (TypeError, ValueError):
            return str(one) == str(other)
    if isinstance(one, str) and isinstance(other, str) and one != other:  # numbers in words, too
        numbers = zip(NUMBER.findall(one), NUMBER.findall(other), strict=False)
        same_words = NUMBER.sub("#", one) == NUMBER.sub("#", other)
        return same_words and all(close(float(a), float(b), rtol) for a, b in numbers)
    return bool(one == other)
