"""Two recordings before their noise is compared: the same markers under the same names, and what
beside the system makes their noise differ."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mocap_metrology.noise.series import AXES, pair_name

Columns = Mapping[str, np.ndarray]  # of allan_masked.parquet
Row = dict[str, Any]
SAME_RATE = 0.01  # frame rates that differ by less are one
# Of half the interval of the logarithm of a ratio: at one averaging time of one coordinate the
# ratio of independent recordings is nearer to 1 with a probability of 8 %
SAME_DATA, LEAST_RATIOS = 0.05, 6
NOTABLE = ("low_pass", "moves")  # findings that are of the export or of the object


@dataclass(frozen=True)
class Side:
    """A recording: its name, columns and metadata of allan_masked.parquet (`labels`, `pairs`,
    `frame_rate_hz`), and findings of diagnosis.json."""

    name: str
    columns: Columns
    origin: Mapping[str, Any]
    findings: Sequence[Mapping[str, Any]] = ()

    def named_as(self, other: Side) -> Side:
        """The same recording with its series named as in another: those of markers of one label
        have one number. Markers that only this one has are left out. Where no label is common to
        both, markers are those of the same number."""
        labels = {label: k for k, label in enumerate(other.origin["labels"], start=1)}
        numbers = {
            k: labels[label]
            for k, label in enumerate(self.origin["labels"], start=1)
            if label in labels
        }
        if not numbers:
            return self
        names = {f"{axis}{k}": f"{axis}{n}" for k, n in numbers.items() for axis in AXES}
        pairs, of_other = ([(a, b) for a, b in one.origin["pairs"]] for one in (self, other))
        distances = {frozenset(pair): pair_name(pair, of_other) for pair in of_other}
        for pair in pairs:
            name = distances.get(frozenset(numbers.get(k, 0) for k in pair))
            names |= {pair_name(pair, pairs): name} if name else {}
        series = self.columns["series"]
        keep = np.isin(series, list(names))
        columns = {name: values[keep] for name, values in self.columns.items()}
        columns["series"] = np.array([names[str(name)] for name in series[keep]], dtype=object)
        return Side(self.name, columns, self.origin, self.findings)


def conditions(new: Side, old: Side, rows: Sequence[Row]) -> list[Row]:
    """What is to be known beside the ratios of two recordings, `rows` of `compare_rows`: rows with
    a `code` and its values.

    `same_data`: all ratios are so near 1 that the recordings are one; `rates`: of frames, `white`
    the ratio that they alone make of equal white noise of a frame; `by_number`: no label is common
    to both; `left_out`: series of `new` without a counterpart; `gone`: labels that only `old` has;
    codes of NOTABLE findings that only the recording `recording` has, with their largest or, of a
    cutoff, lowest `value`.
    """
    codes: list[Row] = []
    if _same_data(rows):
        return [{"code": "same_data"}]
    rates = [float(one.origin["frame_rate_hz"]) for one in (new, old)]
    if abs(math.log(rates[0] / rates[1])) > SAME_RATE:
        white = math.sqrt(rates[1] / rates[0])
        codes.append({"code": "rates", "new_hz": rates[0], "old_hz": rates[1], "white": white})
    gone = [label for label in old.origin["labels"] if label not in new.origin["labels"]]
    if len(gone) == len(old.origin["labels"]):
        codes.append({"code": "by_number"})
    elif gone:
        codes.append({"code": "gone", "recording": old.name, "series": gone})
    compared = {row["series"] for row in rows}
    every = dict.fromkeys(str(name) for name in new.columns["series"])
    if missing := [name for name in every if name not in compared]:
        codes.append({"code": "left_out", "series": missing})
    for code in NOTABLE:
        values = [[f["value"] for f in one.findings if f["code"] == code] for one in (new, old)]
        for one, of_it, of_other in zip((new, old), values, values[::-1], strict=True):
            if of_it and not of_other:
                value = (min if code == "low_pass" else max)(of_it)
                codes.append({"code": code, "recording": one.name, "value": value})
    return codes


def _same_data(rows: Sequence[Row]) -> bool:
    """Whether two recordings agree far better than independent ones do, at all averaging times."""
    of = [row for row in rows if not row["series"].startswith("L")]
    return len(of) >= LEAST_RATIOS and all(
        abs(math.log(row["ratio"])) < SAME_DATA * math.log(row["upper"] / row["lower"]) / 2
        for row in of
    )
