"""Tables I, II and III of J: published beside regenerated, by every variant of the algorithm."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mocap_metrology.lighthouse.published import (
    AVERAGE,
    AVERAGE_SD,
    MAE,
    OVERALL,
    QUANTITIES,
    SETUPS,
    published_value,
)
from mocap_metrology.present.jansen.statistics import (
    NOISY,
    QUANTISED,
    Record,
    Variant,
    by_setup,
    mean_over,
    setup_errors,
    simulated,
    source_of,
    variants_of,
)
from mocap_metrology.present.tables import Row

LAST = {1: OVERALL, 2: AVERAGE}
NOISES = {QUANTISED: "quantisation", NOISY: "quantisation and jitter"}


def jansen_table(number: int, records: Sequence[Record]) -> list[Row]:
    """J Table 1 (mean absolute error) or 2 (standard deviation), long form.

    One row a variant, setup and quantity: `published`, `regenerated`, `ratio`, `n` calibrations,
    `mirrored_share` (mean), `source`. The last row of each variant is the mean over its setups.
    """
    setups = by_setup(records, SETUPS)
    used = [record for of_it in setups.values() for record in of_it]
    rows = []
    for variant in variants_of(used):
        found = {setup: setup_errors(of_it, variant) for setup, of_it in setups.items()}
        values = {s: e.mae() if number == 1 else e.sd() for s, e in found.items()}
        for setup in SETUPS:
            shares = found[setup].mirrored
            rows += _rows(
                number, variant, setup, values[setup], found[setup].n, shares, setups[setup]
            )
        shares = np.concatenate([e.mirrored for e in found.values()])
        total = sum(e.n for e in found.values())
        mean = mean_over(list(values.values()))
        rows += _rows(number, variant, LAST[number], mean, total, shares, used)
    return rows


def jansen_table_3(records: Sequence[Record]) -> list[Row]:
    """J Table 3, long form: MAE and SD of a setup, both averaged over the setups.

    `noise` is `quantisation`, as J simulates, or `quantisation and jitter`, published beside the
    same numbers; `n_setups` and `n` tell how many setups and calibrations stand behind a value.
    """
    rows = []
    for prefix, noise in NOISES.items():
        setups = simulated(records, prefix)
        used = [record for of_it in setups.values() for record in of_it]
        variants = variants_of(used) if used or prefix == QUANTISED else ()
        for variant in (v for v in variants if v.optics == "ideal"):  # as the simulated rotors are
            found = [setup_errors(of_it, variant) for of_it in setups.values()]
            shares = np.concatenate([[], *(e.mirrored for e in found)])
            values = {
                MAE: mean_over([e.mae() for e in found]),
                AVERAGE_SD: mean_over([e.sd() for e in found]),
            }
            for row, value in values.items():
                made = _rows(3, variant, row, value, sum(e.n for e in found), shares, used)
                rows += [
                    {"noise": noise} | r | {"n_setups": sum(e.n > 0 for e in found)} for r in made
                ]
    return rows


def _rows(
    number: int,
    variant: Variant,
    row: str,
    values: np.ndarray,
    n: int,
    shares: np.ndarray,
    records: Sequence[Record],
) -> list[Row]:
    known = shares[np.isfinite(shares)]
    made = []
    for quantity, value in zip(QUANTITIES, values.tolist(), strict=True):
        published = published_value(number, row, quantity)
        made.append(
            {
                "estimator": variant.estimator,
                "stage": variant.stage,
                "optics": variant.optics,
                "setup": row,
                "quantity": quantity,
                "published": published,
                "regenerated": value,
                "ratio": value / published if published else math.nan,
                "n": n,
                "mirrored_share": float(known.mean()) if known.size else math.nan,
                "source": source_of(records) if n else "cited",
            }
        )
    return made
