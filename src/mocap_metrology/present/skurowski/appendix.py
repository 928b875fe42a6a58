"""Tables A1-A3 of S, long form: every printed coefficient beside the regenerated ones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from mocap_metrology.noise.fit.estimates import (
    DEFAULT_ESTIMATOR,
    PLAIN_ESTIMATOR,
    S_ESTIMATOR,
    correlation_class,
    limit_class,
    unit_key,
    unit_of,
)
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.published import (
    printed_row,
    published_keys,
    published_notes,
    published_row,
)
from mocap_metrology.papers.matching import LIMIT, by_estimator, partners
from mocap_metrology.present.skurowski.camera_tables import standing_for
from mocap_metrology.present.tables import Record, Row, source_of

TABLES = {"T40": "A1", "Bonita": "A2", "Vantage": "A3"}
EXPECTED = "expected"
UNPAIRED = "unpaired"
FAR_LINE = 0.1  # relative difference of f_0 worth a note
COLUMNS = (
    "camera_type",
    "n_cameras",
    "printed_row",
    "series",
    "parameter",
    "published",
    "unit",
    "regenerated",
    "regenerated_status",
    "plain",
    "plain_status",
    "expected",
    "likelihood",
    "likelihood_lower_95",
    "likelihood_upper_95",
    "likelihood_status",
    "published_crlb",
    "crlb_relative",
    "supported",
    "source",
    "recording",
    "note",
)
CAPTION = (
    "published: as printed. regenerated: S's estimator (Eq. 13) on the recording, with a local "
    "descent after each trial of its annealing, which S does not use (annealing-ant-colony), so "
    "that its colony finds no further improvement; plain: the same without the descent, as in S "
    "(annealing-ant-colony-plain; empty unless noise.estimators names it). docs/noise.md "
    "compares them. likelihood: this project's default, with its 95 % interval (status "
    "not_detected: no value but an upper limit; the limit of q_c holds for every T_c of its "
    "class). Gauss-Markov terms are paired with the published ones by the smallest total |ln "
    f"T_c|, separately for each estimator; those that differ by more than a factor of {LIMIT:g} "
    f"are not paired (status {UNPAIRED}), and terms without a published one follow as rows of "
    "their own, named by estimator. Only in the CSV: the interval; expected, the result of S's "
    "estimator for the exact Allan variances of the published coefficients; published_crlb, the "
    "least standard error that the length of the recording allows if the published coefficients "
    "are true, and crlb_relative, that over the coefficient; supported, whether it is below the "
    "coefficient itself; printed_row, which is All for ten cameras of one type, as S prints it."
)
FORM_WORDS = {
    "continuous": "Frames of the twins are averages over the frame period: their Allan variances "
    "are the continuous-time formulas, which S fitted, at every averaging time.",
    "sampled": "Frames of the twins are points, as a camera's: at a few frames their Allan "
    "variances are not the continuous-time formulas, which S fitted.",
}
SUPPORT = (
    "supported: number of published coefficients that are larger than the smallest standard "
    "error possible in recordings of this length (Cramer-Rao bound of the published model, all "
    "its coefficients unknown). unsupported: number of the others. not_computed: coefficients "
    "that are not in the twins and have no bound."
)
FROM = ("regenerated", "plain", EXPECTED, DEFAULT_ESTIMATOR)
OWN = {"regenerated": S_ESTIMATOR, "plain": PLAIN_ESTIMATOR}


def table_a(
    camera_type: str,
    recordings: Mapping[str, Record],
    noise: Mapping[str, Sequence[Record]],
    expected: Mapping[str, Sequence[Record]] | None = None,
    crlb: Mapping[tuple[int, str], Mapping[str, float]] | None = None,
) -> list[Row]:
    """Rows of Table A1 (T40), A2 (Bonita) or A3 (Vantage) of S, with the columns `COLUMNS`.

    recordings: rows of the sheet by name (`twin`, `camera_type`, `n_cameras`); noise: rows of
    noise.csv, expected: rows of the same form by annealing-ant-colony on the noise-free curve, both
    by recording; crlb: least standard errors of the published coefficients, by (number of cameras,
    series) and parameter, numbered as printed. What is missing leaves its cells empty. Each printed
    number occurs in exactly one row; then come terms that were not published.
    """
    rows: list[Row] = []
    for n_cameras in (n for kind, n in published_keys() if kind == camera_type):
        name = standing_for(recordings, camera_type, n_cameras)
        common = {
            "camera_type": camera_type,
            "n_cameras": n_cameras,
            "printed_row": "All" if n_cameras == 10 else str(n_cameras),
            "source": source_of(recordings.get(name or "")),
            "recording": name,
        }
        notes, of_all = notes_by_coefficient(camera_type, n_cameras)
        used = published_row(camera_type, n_cameras)
        for series, printed in printed_row(camera_type, n_cameras).items():
            found = by_estimator(noise.get(name or "", ()), series)
            curve = by_estimator((expected or {}).get(name or "", ()), series).get(S_ESTIMATOR, {})
            fits = {
                "regenerated": found.get(S_ESTIMATOR, {}),
                "plain": found.get(PLAIN_ESTIMATOR, {}),
                EXPECTED: curve,
                DEFAULT_ESTIMATOR: found.get(DEFAULT_ESTIMATOR, {}),
            }
            bound = dict((crlb or {}).get((n_cameras, series), {}))
            support = {k: _support(bound.get(k), v) for k, v in used[series].coefficients().items()}
            for row in _series_rows(printed, fits):
                why = [*notes.get((series, row["parameter"]), ()), *of_all, row.pop("note")]
                row |= common | {"series": series, "note": "; ".join(filter(None, why))}
                row |= support.get(row["parameter"], _support(None, math.nan))
                rows.append({column: row[column] for column in COLUMNS})
    return rows


def tables_a(
    recordings: Mapping[str, Record],
    noise: Mapping[str, Sequence[Record]],
    expected: Mapping[str, Sequence[Record]],
) -> dict[str, list[Row]]:
    """`table_a` of every camera type, by the number of its table.

    expected: rows of expected.csv by recording, whose estimator `published` holds the bounds.
    """
    bounds: dict[str, dict[tuple[int, str], dict[str, float]]] = {kind: {} for kind in TABLES}
    for name, rows in expected.items():
        row = recordings[name]
        for found in rows:
            if found["estimator"] == "published":
                key = row["n_cameras"], found["series"]
                of_series = bounds[row["camera_type"]].setdefault(key, {})
                of_series[found["parameter"]] = found["crlb"]
    return {
        number: table_a(kind, recordings, noise, expected, bounds[kind])
        for kind, number in TABLES.items()
    }


def _support(std_error: float | None, value: float) -> Row:
    """Bound of a coefficient from the recording's length; empty where there is none."""
    if std_error is None or math.isnan(std_error) or math.isnan(value):
        return {"published_crlb": std_error, "crlb_relative": None, "supported": None}
    relative = float(std_error) / value if value > 0 else math.inf
    return {"published_crlb": std_error, "crlb_relative": relative, "supported": relative <= 1}


def _series_rows(
    printed: Mapping[str, float], fits: Mapping[str, Mapping[str, Record]]
) -> Iterator[Row]:
    """Rows of one series: the printed coefficients with their partners, then the leftovers."""
    partner = {
        column: partners(printed, {k: r["value"] for k, r in fit.items()})
        for column, fit in fits.items()
    }
    for parameter, value in printed.items():
        row: Row = {"parameter": parameter, "unit": unit_of(parameter)}
        row["published"] = value
        remarks = []
        for column in FROM:
            other = partner[column].get(parameter)
            found = fits[column].get(other or "") or _class_limit(fits[column], parameter, printed)
            row |= _cells(column, found, bool(fits[column]))
            remarks.append(_remark(OWN.get(column, column), parameter, other, row, column))
        yield row | {"note": "; ".join(filter(None, remarks))}
    for column, fit in fits.items():
        taken = set(partner[column].values())
        for name, found in fit.items():
            if name in taken or _number(found["value"]) is None:
                continue
            row = {"parameter": f"{name} ({OWN.get(column, column)})", "published": None}
            row["unit"] = unit_of(name)
            for other in FROM:
                row |= _cells(other, found if other == column else None, False)
            yield row | {"note": "not published"}


def _class_limit(
    fit: Mapping[str, Record], parameter: str, printed: Mapping[str, float]
) -> Record | None:
    """The limit of q_c that an estimate has for the class of this term's T_c, if it has one."""
    if not parameter.startswith("q_c"):
        return None
    kind = correlation_class(printed[f"T_c{parameter[3:]}"])
    return next((row for row in fit.values() if limit_class(row) == kind), None)


def _cells(column: str, found: Record | None, fitted: bool) -> Row:
    """The cells of one estimate: value and status, and the interval of the default one."""
    value = None if found is None else _number(found["value"])
    cells: Row = {column: value}
    if column != EXPECTED:
        status = found["status"] if found is not None else UNPAIRED if fitted else None
        cells[f"{column}_status"] = status
    if column == DEFAULT_ESTIMATOR:
        for end in ("lower_95", "upper_95"):
            cells[f"{column}_{end}"] = None if found is None else _number(found.get(end))
    return cells


def _number(value: float | str | None) -> float | None:
    """A float, or None for what is missing or NaN."""
    if value is None or value == "" or math.isnan(float(value)):
        return None
    return float(value)


def _remark(estimator: str, parameter: str, other: str | None, row: Row, column: str) -> str:
    if other is not None and other != parameter:
        return f"{estimator}: its {other}"
    value = row[column]
    if parameter == "f_0" and value is not None:
        off = value / row["published"] - 1
        if abs(off) > FAR_LINE:
            return f"{estimator}: f_0 differs by {100 * off:+.2g} %"
    return ""


def notes_by_coefficient(
    camera_type: str, n_cameras: int
) -> tuple[dict[tuple[str, str], list[str]], list[str]]:
    """`published_notes` by (series, coefficient), and those that hold for all series."""
    notes: dict[tuple[str, str], list[str]] = {}
    of_all = []
    for line in published_notes(camera_type, n_cameras):
        where, text = line.split(": ", 1)
        if where == "all series":
            of_all.append(text)
            continue
        series, names = where.split(" ", 1)
        for name in names.split(", "):
            notes.setdefault((series, name), []).append(text)
    return notes, of_all


def support_counts(rows: Sequence[Row]) -> list[Row]:
    """How many published coefficients are beyond the recordings' length (relative CRLB > 1).

    rows: of `table_a`, of one camera type or several. One row a camera type and kind of
    coefficient, and `all`; not_computed: no bound was given, as of a sinusoid above Nyquist.
    """
    counts: dict[tuple[str, str], Row] = {}
    for row in rows:
        if row["published"] is None:
            continue
        for kind in (unit_key(row["parameter"]), "all"):
            start = dict.fromkeys(("published", "supported", "unsupported", "not_computed"), 0)
            count = counts.setdefault((row["camera_type"], kind), start)
            count["published"] += 1
            word = {True: "supported", False: "unsupported"}.get(row["supported"], "not_computed")
            count[word] += 1
    order = [*NoiseModel.UNITS, "all"]
    types = dict.fromkeys(kind for kind, _ in counts)
    return [
        {"camera_type": t, "parameter": k} | counts[t, k]
        for t in types for k in order if (t, k) in counts
    ]  # fmt: skip
