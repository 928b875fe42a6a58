"""S Tables A1-A3, long form: every printed coefficient beside the regenerated ones, how many of
them the length of the recordings supports, and what became of the white noise."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from mocap_metrology.noise.fit import estimates as est
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins import published
from mocap_metrology.papers.subsets import Sheet, source_of, standing_for

TABLES = {"T40": "A1", "Bonita": "A2", "Vantage": "A3"}
LIMIT = 10.0  # correlation times that differ by a greater factor are of different components
UNPAIRED = "unpaired"
FAR_LINE = 0.1  # relative difference of f_0 worth a note
COLUMNS = (
    *("camera_type", "n_cameras", "printed_row", "series", "parameter", "published", "unit"),
    *("regenerated", "regenerated_status", "plain", "plain_status", "expected", "likelihood"),
    *("likelihood_lower_95", "likelihood_upper_95", "likelihood_status", "published_crlb"),
    *("crlb_relative", "supported", "source", "recording", "note"),
)
ESTIMATORS = {  # by column
    "regenerated": est.S_ESTIMATOR,
    "plain": est.PLAIN_ESTIMATOR,
    "expected": "expected",
    "likelihood": est.DEFAULT_ESTIMATOR,
}
COUNTED = ("published", "supported", "unsupported", "not_computed")
NEAR = 0.05  # what counts as the same white level
BOUNDS = 3.0  # or so many Cramer-Rao bounds, where they are wider
Row = dict[str, Any]
Noise = Mapping[str, Sequence[Mapping[str, Any]]]  # rows of noise.csv by recording
Fit = Mapping[str, Mapping[str, Any]]  # of one series and estimator, by parameter


def table_a(camera_type: str, recordings: Sheet, noise: Noise, expected: Noise) -> list[Row]:
    """Rows of Table A1 (T40), A2 (Bonita) or A3 (Vantage) of S, with the columns `COLUMNS`.

    recordings: rows of the sheet (`twin`, `camera_type`, `n_cameras`); expected: rows of
    expected.csv, by S's estimator on the noise-free curve, and by `published` with the least
    standard errors (`crlb`). What is missing leaves its cells empty. Each printed number occurs in
    exactly one row; then come terms that were not published.
    """
    rows: list[Row] = []
    for n_cameras in (n for kind, n in published.published_keys() if kind == camera_type):
        name = standing_for(recordings, camera_type, n_cameras) or ""
        common = {"camera_type": camera_type, "n_cameras": n_cameras}
        common |= {"printed_row": "All" if n_cameras == 10 else str(n_cameras)}
        common |= {"source": source_of(recordings.get(name)), "recording": name or None}
        notes, of_all = notes_by_coefficient(camera_type, n_cameras)
        models = published.published_row(camera_type, n_cameras)
        for series, printed in published.printed_row(camera_type, n_cameras).items():
            estimates = by_estimator(noise.get(name, ()), series)
            exact = by_estimator(expected.get(name, ()), series)
            fits = {column: estimates.get(by, {}) for column, by in ESTIMATORS.items()}
            fits["expected"] = exact.get(est.S_ESTIMATOR, {})
            bounds, used = exact.get("published", {}), models[series].coefficients()
            for row in _series_rows(printed, fits):
                parameter = row["parameter"]
                if parameter in bounds and parameter in used:
                    bound, value = float(bounds[parameter]["crlb"]), used[parameter]
                    row["published_crlb"] = bound
                    if not math.isnan(bound):  # as without a bound by the recording's length
                        relative = bound / value if value > 0 else math.inf
                        row |= {"crlb_relative": relative, "supported": relative <= 1}
                remarks = [*notes.get((series, parameter), ()), *of_all, row["note"]]
                row |= common | {"series": series, "note": "; ".join(filter(None, remarks))}
                rows.append({column: row.get(column) for column in COLUMNS})
    return rows


def notes_by_coefficient(
    camera_type: str, n_cameras: int
) -> tuple[dict[tuple[str, str], list[str]], list[str]]:
    """`published_notes` by (series, coefficient), and those that hold for all series."""
    notes: dict[tuple[str, str], list[str]] = defaultdict(list)
    of_all = []
    for line in published.published_notes(camera_type, n_cameras):
        place, text = line.split(": ", 1)
        if place == "all series":
            of_all.append(text)
            continue
        series, names = place.split(" ", 1)
        for name in names.split(", "):
            notes[series, name].append(text)
    return notes, of_all


def _series_rows(printed: Mapping[str, float], fits: Mapping[str, Fit]) -> Iterator[Row]:
    """Rows of one series: the printed coefficients with their partners, then the leftovers."""
    partner = {
        column: partners(printed, {name: row["value"] for name, row in fit.items()})
        for column, fit in fits.items()
    }
    for parameter, value in printed.items():
        row: Row = {"parameter": parameter, "unit": est.unit_of(parameter), "published": value}
        remarks = []
        for column, fit in fits.items():
            other = partner[column].get(parameter)
            estimate = fit.get(other or "")
            if estimate is None and parameter.startswith("q_c"):  # its limit in the class of T_c
                kind = est.correlation_class(printed[f"T_c{parameter[3:]}"])
                estimate = next((one for one in fit.values() if est.limit_class(one) == kind), None)
            row |= _cells(column, estimate, UNPAIRED if fit else None)
            if other is not None and other != parameter:
                remarks.append(f"{ESTIMATORS[column]}: its {other}")
            elif parameter == "f_0" and row[column] and abs(row[column] / value - 1) > FAR_LINE:
                off = f"{100 * (row[column] / value - 1):+.2g} %"
                remarks.append(f"{ESTIMATORS[column]}: f_0 differs by {off}")
        yield row | {"note": "; ".join(remarks)}
    for column, fit in fits.items():
        for name, estimate in fit.items():
            cells = _cells(column, estimate, None)
            if name not in partner[column].values() and cells[column] is not None:
                row = {"parameter": f"{name} ({ESTIMATORS[column]})", "unit": est.unit_of(name)}
                yield row | cells | {"note": "not published"}


def _cells(column: str, estimate: Mapping[str, Any] | None, status: str | None) -> Row:
    """Value, interval and status of an estimate, or the status without one."""
    if estimate is None:
        return {column: None, f"{column}_status": status}
    names = {"value": column} | {end: f"{column}_{end}" for end in ("lower_95", "upper_95")}
    numbers = {cell: estimate.get(name) for name, cell in names.items()}
    cells: Row = {k: None if v is None or math.isnan(v) else v for k, v in numbers.items()}
    return cells | {f"{column}_status": estimate["status"]}


def support_counts(rows: Sequence[Row]) -> list[Row]:
    """How many published coefficients the length of the recordings supports (relative Cramer-Rao
    bound of 1 at most): one row a camera type and kind of coefficient, and `all`.

    rows: of `table_a`, of one camera type or several; not_computed: no bound was given, as of a
    sinusoid above Nyquist.
    """
    words = {True: "supported", False: "unsupported", None: "not_computed"}
    counts: dict[str, Counter[tuple[str, str]]] = defaultdict(Counter)
    for row in rows:
        if row["published"] is not None:
            for kind in (est.unit_key(row["parameter"]), "all"):
                both = (kind, "published"), (kind, words[row["supported"]])
                counts[row["camera_type"]].update(both)
    return [
        {"camera_type": camera_type, "parameter": kind}
        | {word: count[kind, word] for word in COUNTED}
        for camera_type, count in counts.items()
        for kind in (*NoiseModel.UNITS, "all")
        if count[kind, "published"]
    ]


def white_levels(rows: Sequence[Row]) -> list[Row]:
    """h_0 of every published series, out of rows of `table_a`: deviations in per cent of the
    expected and likelihood values from the published one, and of the regenerated from the expected
    one; likelihood may deviate by 5 %, or by three Cramer-Rao bounds."""
    return [
        {k: row[k] for k in ("camera_type", "n_cameras", "series", "published", "expected")}
        | {"expected_percent": _percent(row["expected"], row["published"])}
        | {"regenerated": row["regenerated"]}
        | {"regenerated_percent": _percent(row["regenerated"], row["expected"])}
        | {"likelihood": row["likelihood"]}
        | {"likelihood_percent": _percent(row["likelihood"], row["published"])}
        | {"likelihood_allowed_percent": 100 * max(NEAR, BOUNDS * (row["crlb_relative"] or 0.0))}
        | {k: row[k] for k in ("source", "recording")}
        for row in rows
        if row["parameter"] == "h_0" and row["published"] is not None
    ]


def _percent(value: float | None, reference: float | None) -> float | None:
    return None if value is None or not reference else 100 * (value / reference - 1)


def count_white_levels(levels: Sequence[Row]) -> Row:
    """Counts of the series that have a recording: all; those of which the expected and the
    regenerated level deviate by more than 5 %; those in which likelihood deviates by more than is
    allowed."""
    known = [row for row in levels if row["recording"]]
    far = {
        name: sum(not _within(row[f"{name}_percent"], 100 * NEAR) for row in known)
        for name in ("expected", "regenerated")
    }
    beyond = [
        f"{row['camera_type']}-{row['n_cameras']} {row['series']}"
        for row in known
        if not _within(row["likelihood_percent"], row["likelihood_allowed_percent"])
    ]
    return {"series": len(known), "beyond": beyond} | far


def _within(percent: float | None, limit: float) -> bool:
    return percent is not None and abs(percent) <= limit


def searched_ends(rows: Sequence[Row]) -> list[float]:
    """The T_c, in s, at which the search of S's estimator ended: shortest and longest."""
    ended = [
        row["regenerated"]
        for row in rows
        if row["parameter"].startswith("T_c") and row["regenerated_status"] == "at_bound"
    ]
    return sorted({min(ended), max(ended)}) if ended else []


# Which fitted and published terms belong together


def by_estimator(
    rows: Iterable[Mapping[str, Any]], series: str
) -> dict[str, dict[str, Mapping[str, Any]]]:
    """Rows of one series of noise.csv: estimator -> parameter -> row, in their order."""
    by_name: dict[str, dict[str, Mapping[str, Any]]] = {}
    for row in rows:
        if row["series"] == series:
            by_name.setdefault(row["estimator"], {})[row["parameter"]] = row
    return by_name


def correlation_times(values: Mapping[str, float]) -> dict[int, float]:
    """Number -> T_c of the Gauss-Markov terms that have one; the rest is passed over."""
    return {
        int(name[3:]): float(value)
        for name, value in values.items()
        if name.startswith("T_c") and value is not None and 0 < float(value) < math.inf
    }


def pair(published: Mapping[int, float], fitted: Mapping[int, float]) -> dict[int, int]:
    """Published number -> fitted number of the Gauss-Markov terms that belong together.

    Least sum of |ln(T_c / T_c')| over all assignments (Kuhn 1955), in which a term without a
    partner costs as much as a pair that differs by the factor `LIMIT`; so no pair differs by more,
    and a good pair is not split into two poor ones.
    """
    from scipy.optimize import linear_sum_assignment

    if not published or not fitted:
        return {}
    rows, columns = list(published), list(fitted)
    ours, theirs = np.log(list(published.values())), np.log(list(fitted.values()))
    distance = np.abs(ours[:, None] - theirs[None, :])
    far = math.log(LIMIT) * (1 + 1e-12)
    chosen = linear_sum_assignment(np.minimum(distance, far))
    return {
        rows[i]: columns[j]
        for i, j in zip(*(k.tolist() for k in chosen), strict=True)
        if distance[i, j] <= far
    }


def partners(published: Mapping[str, float], fitted: Mapping[str, float]) -> dict[str, str]:
    """Published parameter -> fitted parameter: Gauss-Markov terms by `pair`, others by name."""
    terms = pair(correlation_times(published), correlation_times(fitted))
    pairs = {name: name for name in published if name[1:3] != "_c" and name in fitted}
    for number, other in terms.items():
        for name in ("q_c", "T_c"):
            if f"{name}{number}" in published and f"{name}{other}" in fitted:
                pairs[f"{name}{number}"] = f"{name}{other}"
    return pairs
