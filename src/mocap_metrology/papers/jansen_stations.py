"""Tables I to III of J as J would have measured them with stations of the second generation.

J sums up the errors of one slave; here those of all stations but the reference, by the number of
stations. Mean absolute errors are over recordings and stations, standard deviations (n - 1) over
the recordings of a setup, of each station; both are averaged over setups.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from mocap_metrology.common.types import Record
from mocap_metrology.lighthouse import published as printed
from mocap_metrology.papers.jansen import mean_over

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
