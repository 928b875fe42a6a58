"""Tables A1-A3 of S to read: panels (a) x1 ... (g) L as in the paper, and h_0 of every series."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mocap_metrology.noise.fit import estimates
from mocap_metrology.noise.twins import published as printed
from mocap_metrology.papers import coefficient_tables
from mocap_metrology.papers.gaussian_table import REPEATS, by_relation
from mocap_metrology.present.tables import Part, Row, document
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import MARKS, STATUS_SIGNS, duration_words, significant

CAPTION = captions.TABLE_A.format(
    factor=coefficient_tables.LIMIT, unpaired=coefficient_tables.UNPAIRED
)
FORM_WORDS = captions.texts("FORMS")
UNSUPPORTED, LEFT_OUT = "†", "‡"
NOT_COMPUTED = "Which numbers {length} can support was not computed."
COUNTS = "{length} cannot support {unsupported} of the {published} published numbers{rest}."
TABLE_1_SHOWN = (
    *("noise", "alpha", "scale", "formula", "quantity", "tau_s", "f_h_hz", "published"),
    *("regenerated", "standard_error", "expected", "deviation_percent", "errors_off", "method"),
    *("source", "note"),
)
TABLE_4_CAPTION = captions.TABLE_4.format(repeats=REPEATS)
TABLE_4_SHOWN = (
    *("camera_type", "quantity", "published", "regenerated", "source", "standard_error"),
    *("lower_5", "median", "upper_95", "inside", "nine_hours_lower_5", "nine_hours_upper_95"),
    *("published_inside", "check", "residual", "published_residual", "note"),
)
BY_CHANCE = "regenerated outside: by chance, as for one number in ten of a twin"
OTHER_VALUE = "the printed coefficients give a different value"
WALK = "h_-2 of L is printed as {L}, of x1 and x2 together as {both}, which {word}correlates them"
OF_T40_X1 = (
    "the printed coefficients of x1 are too small for it: h_-2 is 1.55×10⁻¹⁰ for ten cameras "
    "and 2.99×10⁻⁹ for eight, and the latter agrees"
)
OF_T40 = {
    "sigma_1_mm": "",
    "sigma_12_mm2": "contains sigma_1: ",
    "rho_12": "higher for a wider x1 with the same L: ",
    "sigma_A1_mm": "sqrt(2) sigma_1: ",
    "sigma_B_mm": "contains sigma_1: ",
}
SCALED = "no coefficients of all thirty cameras were printed: T40-10 scaled to this row"
NOTES: dict[str | tuple[str, str], str] = {  # by quantity, or by camera type and quantity
    "sigma_12_mm2": "printed with four decimals: sigma_C from it would be {from_covariance:.4f}, "
    "from rho_12 {from_rho:.4f}",
    "sigma_B_mm": "S prints the formula with sigma_1 twice",
    "mu_L_mm": "printed {across:.4f} above mu_e: the markers are not quite along x",
    **dict.fromkeys([("All", name) for name in ("sigma_1_mm", "sigma_2_mm", "rho_12")], SCALED),
    ("Vantage", "sigma_1_mm"): "the printed row agrees with nine cameras, not ten",
}


def table_a_markdown(
    rows: Sequence[Row], title: str, caption: str, duration_s: float | None = None
) -> str:
    """Markdown of the rows of one `table_a`: a panel a series, full digits are in the CSV.

    duration_s: length of the recordings, where it is known.
    """
    length = "this length" if duration_s is None else duration_words(duration_s)
    length = f"a recording of {length}"
    of = estimates.S_ESTIMATOR, estimates.PLAIN_ESTIMATOR, estimates.DEFAULT_ESTIMATOR
    named = dict(zip(("of_paper", "plain", "default"), of, strict=True))
    named |= {"unsupported": UNSUPPORTED, "left_out": LEFT_OUT, "signs": STATUS_SIGNS}
    signs = captions.TABLE_A_SIGNS.format(length=length, **named)
    counts = coefficient_tables.support_counts(rows)
    total = next((count for count in counts if count["parameter"] == "all"), None)
    support = NOT_COMPUTED.format(length=length)
    if total is not None and total["not_computed"] < total["published"]:
        rest = f", {total['not_computed']} have no bound" if total["not_computed"] else ""
        support = COUNTS.format(**total, length=length[:1].upper() + length[1:], rest=rest)
    parts: list[Part] = [caption, signs, support]
    for kind, n in dict.fromkeys((row["camera_type"], row["n_cameras"]) for row in rows):
        notes = coefficient_tables.notes_by_coefficient(kind, n)[1]
        parts += [f"{n} cameras, all series: {note}." for note in notes]
    for letter, series in zip("abcdefg", printed.SERIES, strict=True):
        if panel := [row for row in rows if row["series"] == series]:
            parts += [f"## ({letter}) {series}", _panel(panel), "\n".join(_notes(panel))]
    return document(title, *parts)


def _panel(rows: Sequence[Row]) -> list[list[str]]:
    """Lines for each number of cameras: published, then each estimator that was run."""
    cells = {(r["n_cameras"], r["parameter"]): r for r in rows if r["published"] is not None}
    parameters = {parameter for _, parameter in cells}
    names = [name for name in printed.COEFFICIENTS if name in parameters]
    lines = [["cameras", "", *(f"{name} ({estimates.unit_of(name)})" for name in names)]]
    for n_cameras in dict.fromkeys(row["n_cameras"] for row in rows):
        of_row = [cells.get((n_cameras, name)) for name in names]
        lines.append([str(n_cameras), "published", *(_published(r) if r else "" for r in of_row)])
        for column in ("regenerated", "plain", "likelihood"):
            texts = [_estimated(row, column) if row else "" for row in of_row]
            if any(texts):
                lines.append(["", coefficient_tables.ESTIMATORS[column], *texts])
    return lines


def _published(row: Row) -> str:
    sign = UNSUPPORTED if row["supported"] is False else ""
    return significant(row["published"]) + sign + (LEFT_OUT if _own_notes(row) else "")


def _own_notes(row: Row) -> list[str]:
    notes, _ = coefficient_tables.notes_by_coefficient(row["camera_type"], row["n_cameras"])
    return notes.get((row["series"], row["parameter"]), [])


def _estimated(row: Row, column: str) -> str:
    status = row[f"{column}_status"]
    if status == "not_detected":
        upper = row.get(f"{column}_upper_95")
        return f"< {significant(upper)}" if upper is not None else "not detected"
    if status == coefficient_tables.UNPAIRED:
        return "–"
    return significant(row[column]) + MARKS.get(status, "") if row[column] is not None else ""


def _notes(rows: Sequence[Row]) -> list[str]:
    """Notes on published numbers, and the terms that were not published."""
    noted: dict[str, list[str]] = {}
    others: dict[str, list[str]] = {}
    for row in rows:
        cameras, parameter = f"- {row['n_cameras']} cameras", row["parameter"]
        if row["published"] is not None:
            for note in _own_notes(row):
                noted.setdefault(f"{cameras}, {{}}{LEFT_OUT}: {note}", []).append(parameter)
            continue
        name, _, estimator = parameter.partition(" (")
        values = (row[column] for column in coefficient_tables.ESTIMATORS)
        value = next(value for value in values if value is not None)
        group = others.setdefault(f"{cameras}, {estimator[:-1]}, not published: {{}}", [])
        group.append(f"{name} {significant(value)} {row['unit']}")
    return [text.format(", ".join(names)) for text, names in (noted | others).items()]


def white_level_sentence(levels: Sequence[Row]) -> str:
    """The counts that a reader of the white levels looks for."""
    counts = coefficient_tables.count_white_levels(levels)
    beyond = counts["beyond"]
    names = f" ({', '.join(beyond)})" if beyond else ""
    return captions.WHITE_COUNTS.format(**counts | {"beyond": len(beyond), "names": names})


def note_of_table_4(row: Row) -> str:
    """Why a number of `papers.gaussian_table.table_4` cannot agree, or is less than it seems."""
    kind, quantity = row["camera_type"], row["quantity"]
    published = printed.published_gaussian(kind)
    s_1, s_2 = published["sigma_1_mm"], published["sigma_2_mm"]
    numbers = {
        "from_covariance": math.sqrt(s_1**2 + s_2**2 - 2 * published["sigma_12_mm2"]),
        "from_rho": by_relation("sigma_C_mm", published),
        "across": published["mu_L_mm"] - published["mu_e_mm"],
    }
    notes = [BY_CHANCE] if row["inside"] is False else []
    if row["published_inside"] is False:
        notes.append(f"published outside: {_reason(kind, quantity)}")
    notes += [NOTES[key].format(**numbers) for key in (quantity, (kind, quantity)) if key in NOTES]
    return "; ".join(notes)


def _reason(kind: str, quantity: str) -> str:
    """Why a printed number lies outside of what the printed coefficients allow."""
    if kind == "T40" and quantity in OF_T40:
        return OF_T40[quantity] + OF_T40_X1
    if quantity not in ("sigma_12_mm2", "rho_12"):
        return OTHER_VALUE
    models = printed.published_row(kind, 9 if kind == "Vantage" else 10)
    walk = {s: models[s].coefficients().get("h_-2", 0.0) for s in ("x1", "x2", "L")}
    both = walk["x1"] + walk["x2"]
    word = "de" if walk["L"] > both else ""
    return WALK.format(L=significant(walk["L"]), both=significant(both), word=word)
