"""Tables I, II and III of J: published beside regenerated, by every variant of the algorithm.

Errors are summed up as J does: mean absolute error and standard deviation.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mocap_metrology.common.types import Record
from mocap_metrology.lighthouse import published as printed

ESTIMATORS = ("paper", "paper-tight", "paper-lm", "batch")
STAGES = ("kabsch", "final")
OPTICS = ("ideal", "factory")
QUANTISED, NOISY = "sim-", "noise-"  # setups of Table III: sample error alone, and further noise
NOISES = {QUANTISED: "quantisation", NOISY: "quantisation and jitter"}
LAST = {1: printed.OVERALL, 2: printed.AVERAGE}
FACTOR = 4.0  # beyond it a regenerated value is explained


@dataclass(frozen=True, order=True)
class Variant:
    """One way to calibrate."""

    estimator: str
    stage: str
    optics: str

    def __str__(self) -> str:
        return f"{self.estimator}, {self.stage}, {self.optics} optics"


VARIANTS = tuple(Variant(e, s, o) for o in OPTICS for e in ESTIMATORS for s in STAGES)


@dataclass(frozen=True)
class SetupErrors:
    """Errors of the calibrations of one setup by one variant: (n, 6) in mm and deg, see QUANTITIES;
    mirrored share of each (n,)."""

    errors: np.ndarray
    mirrored: np.ndarray

    @property
    def n(self) -> int:
        return len(self.errors)

    def mae(self) -> np.ndarray:
        """Mean absolute error (6,), NaN without a calibration."""
        return np.abs(self.errors).mean(axis=0) if self.n else np.full(6, np.nan)

    def sd(self) -> np.ndarray:
        """Standard deviation (6,), n - 1 in the denominator; NaN for fewer than two."""
        return self.errors.std(axis=0, ddof=1) if self.n > 1 else np.full(6, np.nan)


def paper_setup(setup: str) -> str | None:
    """Row of Tables I and II for a setup of the sheet: `3` of `3`, `real-3`, `setup3`;
    None for those of the simulation and for numbers that J has not."""
    if setup.startswith((QUANTISED, NOISY)):
        return None
    number = re.fullmatch(r"(?:.*[^0-9])?0*([0-9]+)", setup)
    return number[1] if number and number[1] in printed.SETUPS else None


def pose_of(record: Record, variant: Variant) -> Record | None:
    """The pose by a variant that has errors against a reference."""
    poses: Sequence[Record] = record["pose"]["poses"]
    for pose in poses:
        same = Variant(pose["estimator"], pose["stage"], pose["optics"]) == variant
        if same and pose.get("errors_mm") is not None:
            return pose
    return None


def setup_errors(records: Sequence[Record], variant: Variant) -> SetupErrors:
    """Errors of all records by one variant; records without it are omitted."""
    poses = [pose for record in records if (pose := pose_of(record, variant)) is not None]
    errors = [[*pose["errors_mm"], *pose["errors_deg"]] for pose in poses]
    shares = [pose.get("mirrored_share") for pose in poses]
    return SetupErrors(
        np.array(errors, dtype=np.float64).reshape(-1, len(printed.QUANTITIES)),
        np.array([math.nan if share is None else share for share in shares]),
    )


def mean_over(rows: Iterable[np.ndarray]) -> np.ndarray:
    """Mean (6,) over the setups that have a value; NaN without one."""
    values = np.array(list(rows), dtype=np.float64).reshape(-1, len(printed.QUANTITIES))
    values = values[np.isfinite(values).all(axis=1)]
    return values.mean(axis=0) if len(values) else np.full(len(printed.QUANTITIES), np.nan)


def source_of(records: Sequence[Record]) -> str:
    """`twin`, `measured`, `twin and measured`, or `cited` where there is no record."""
    kinds = sorted({record["source"] for record in records}, reverse=True)
    return " and ".join(kinds) if kinds else "cited"


def by_setup(records: Sequence[Record]) -> dict[str, list[Record]]:
    """Records of each setup of Tables I and II; empty lists for those without any."""
    return {s: [r for r in records if paper_setup(r["setup"]) == s] for s in printed.SETUPS}


def simulated(records: Sequence[Record], prefix: str) -> dict[str, list[Record]]:
    """Records of each simulated setup whose name begins so, in order of appearance."""
    setups = dict.fromkeys(r["setup"] for r in records if r["setup"].startswith(prefix))
    return {setup: [r for r in records if r["setup"] == setup] for setup in setups}


def _variants_of(records: Sequence[Record]) -> tuple[Variant, ...]:
    """Variants that at least one record has, in the order of `VARIANTS`; all without records."""
    have = tuple(v for v in VARIANTS if any(pose_of(record, v) for record in records))
    return have or VARIANTS


def jansen_table(number: int, records: Sequence[Record]) -> list[dict[str, Any]]:
    """J Table 1 (mean absolute error) or 2 (standard deviation), long form.

    One row a variant, setup and quantity: `published`, `regenerated`, `ratio`, `n` calibrations,
    `mirrored_share` (mean), `source`. The last row of each variant is the mean over its setups.
    """
    setups = by_setup(records)
    used = [record for of_it in setups.values() for record in of_it]
    rows = []
    for variant in _variants_of(used):
        errors = {setup: setup_errors(of_it, variant) for setup, of_it in setups.items()}
        values = {s: e.mae() if number == 1 else e.sd() for s, e in errors.items()}
        for setup, of_it in setups.items():
            rows += _rows(number, variant, setup, values[setup], [errors[setup]], of_it)
        mean = mean_over(values.values())
        rows += _rows(number, variant, LAST[number], mean, list(errors.values()), used)
    return rows


def jansen_table_3(records: Sequence[Record]) -> list[dict[str, Any]]:
    """J Table 3, long form: MAE and SD of a setup, both averaged over the setups.

    `noise` is `quantisation`, as J simulates, or `quantisation and jitter`, published beside the
    same numbers; `n_setups` and `n` are the numbers of setups and calibrations behind a value.
    """
    rows = []
    for prefix, noise in NOISES.items():
        setups = simulated(records, prefix)
        used = [record for of_it in setups.values() for record in of_it]
        variants = _variants_of(used) if used or prefix == QUANTISED else ()
        for variant in (v for v in variants if v.optics == "ideal"):  # as the simulated rotors are
            errors = [setup_errors(of_it, variant) for of_it in setups.values()]
            mae, sd = mean_over(e.mae() for e in errors), mean_over(e.sd() for e in errors)
            n_setups = sum(e.n > 0 for e in errors)
            for name, value in ((printed.MAE, mae), (printed.AVERAGE_SD, sd)):
                of_it = _rows(3, variant, name, value, errors, used)
                rows += [{"noise": noise} | row | {"n_setups": n_setups} for row in of_it]
    return rows


def _rows(
    number: int,
    variant: Variant,
    setup: str,
    values: np.ndarray,
    errors: Sequence[SetupErrors],
    records: Sequence[Record],
) -> list[dict[str, Any]]:
    n, shares = sum(e.n for e in errors), np.concatenate([[], *(e.mirrored for e in errors)])
    known = shares[np.isfinite(shares)]
    rows = []
    for quantity, value in zip(printed.QUANTITIES, values.tolist(), strict=True):
        published = printed.published_value(number, setup, quantity)
        row = {**vars(variant), "setup": setup, "quantity": quantity, "published": published}
        row |= {"regenerated": value, "ratio": value / published if published else math.nan}
        row |= {"n": n, "mirrored_share": float(known.mean()) if known.size else math.nan}
        rows.append(row | {"source": source_of(records) if n else "cited"})
    return rows


# ---- As J would have measured with stations of the second generation: the errors of all stations
# but the reference, by the number of stations. Mean absolute errors are over recordings and
# stations, standard deviations (n - 1) over the recordings of a setup, of each station; both are
# averaged over setups.

IDEAL = "-ideal-"  # in the name of a setup: nothing but the clock's step is wrong, as in Table III
PUBLISHED = ((1, printed.OVERALL), (2, printed.AVERAGE))  # rows of J's tables of real stations


def _errors(record: Record) -> dict[str, list[float]]:
    """Errors of the chosen pose of each station against its reference, mm and deg."""
    document = record["pose"]
    chosen: Mapping[str, int | None] = document["chosen"] or {}
    poses = {name: document["poses"][k] for name, k in chosen.items() if k is not None}
    return {
        name: [*pose["errors_mm"], *pose["errors_deg"]]
        for name, pose in poses.items()
        if pose.get("errors_mm") is not None
    }


def _summed(of_setup: Sequence[Record]) -> tuple[np.ndarray, np.ndarray, int]:
    """Mean absolute error (6,), standard deviation (6,), and number of calibrations with errors."""
    errors_of = [errors for record in of_setup if (errors := _errors(record))]
    none = np.full(len(printed.QUANTITIES), np.nan)
    if not errors_of:
        return none, none, 0
    every = np.array([values for errors in errors_of for values in errors.values()])
    names = {name for errors in errors_of for name in errors}
    by_station = [np.array([e[name] for e in errors_of if name in e]) for name in sorted(names)]
    sd = mean_over(errors.std(axis=0, ddof=1) for errors in by_station if len(errors) > 1)
    return np.abs(every).mean(axis=0), sd, len(errors_of)


def stations_tables(records: Sequence[Record]) -> Iterator[dict[str, Any]]:
    """Long form: `table` 1 (mean absolute error), 2 (standard deviation) or 3 (`MAE`, `Average SD`
    of ideal twins, in `row`), `stations`, `quantity`, J's `published` value for two stations of the
    first generation, and `regenerated`."""
    numbers = sorted({len(record["pose"]["stations"]) for record in records})
    for ideal in (False, True):
        for n in numbers:
            chosen = [r for r in records if len(r["pose"]["stations"]) == n]
            chosen = [r for r in chosen if (IDEAL in r["setup"]) == ideal]
            setups = {r["setup"]: [o for o in chosen if o["setup"] == r["setup"]] for r in chosen}
            summed = [_summed(of_setup) for of_setup in setups.values()]
            if not summed:
                continue
            values = [mean_over(mae for mae, *_ in summed), mean_over(sd for _, sd, _ in summed)]
            named = ((3, printed.MAE), (3, printed.AVERAGE_SD)) if ideal else PUBLISHED
            for (table, row), value in zip(named, values, strict=True):
                for quantity, number in zip(printed.QUANTITIES, value.tolist(), strict=True):
                    yield {
                        "table": table,
                        "row": row,
                        "stations": n,
                        "quantity": quantity,
                        "published": printed.published_value(table, row, quantity),
                        "regenerated": number,
                        "n_setups": len(setups),
                        "n": sum(one[2] for one in summed),
                        "source": " and ".join(sorted({r["source"] for r in chosen})),
                    }


def cells(rows: Sequence[Mapping[str, Any]]) -> list[list[object]]:
    """Wide form for a page: a line for each table, row and number of stations, J's first."""
    lines: list[list[object]] = []
    keys = dict.fromkeys((r["table"], r["row"]) for r in rows)
    for table, row in keys:
        of_row = [r for r in rows if (r["table"], r["row"]) == (table, row)]
        numbers = list(dict.fromkeys(r["stations"] for r in of_row))
        lines.append(
            [
                table,
                row,
                "J: 2 (V1)",
                *_formatted(of_row[: len(printed.QUANTITIES)], "published"),
                "",
            ]
        )
        for n in numbers:
            of_n = [r for r in of_row if r["stations"] == n]
            lines.append([table, row, n, *_formatted(of_n, "regenerated"), of_n[0]["n"]])
    return lines


def _formatted(rows: Sequence[Mapping[str, Any]], key: str) -> list[str]:
    values = [(row[key], row["quantity"].endswith("_mm")) for row in rows]
    return ["" if v is None else f"{v:.{2 if mm else 3}f}" for v, mm in values]
