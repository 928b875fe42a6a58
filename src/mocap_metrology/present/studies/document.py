"""The studies of J's claims as a person reads them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from mocap_metrology.present.studies.points import NOTICEABLE, SHOWN, Shown, first_of_methods
from mocap_metrology.present.tables import Row, aligned
from mocap_metrology.present.text.numbers import significant

CAPTION = (
    "Simulated recordings ({n} at each point, {seconds:g} s each, seed {seed}): one circumstance "
    "varies, the others are those of a base case (flat board of 32 diodes, moved by hand at up to "
    "0.4 m/s, 3 m from both stations, which are 2 m apart). Angles have 53 µrad of noise in common "
    "to a sweep and 49 µrad of each hit, quantisation included; rotors are ideal. Errors are those "
    "of the slave's pose between the optical frames. paper: J's simplex; paper-lm: "
    "Levenberg-Marquardt with the mirror test; batch: all hits in one estimate; pnp, geometric: "
    "the peers that J discusses; kabsch: before the last minimisation, final: after it. Medians "
    "have the interval of order statistics that contains the median with at least 95 %. r is "
    "Spearman's rank correlation of the error in mm with the circumstance over single recordings, "
    "its 95 % interval by Fisher's z with the variance of Bonett & Wright (2000); of motion "
    "patterns, with whether a recording has this one. A recording without a pose counts as worse "
    "than any with one; values at which no recording has one are not in r. Ratios are medians over "
    "recordings of the error divided by that of {reference} in the same recording. Noticeable: "
    f"|r| of {NOTICEABLE} or more, what 40 recordings, as J has, show with p < 0.05; undecided: "
    "the interval is on both sides of that limit. beyond 8°: poses of the slave that are wrong by "
    "more than 8°; mirrored: median share of board poses in the mirrored minimum."
)
WORDS = {"full-interpolation": "full interpolation", "kabsch": "Kabsch", "final": "final"}


def method_text(row: Mapping[str, object]) -> str:
    """`paper, Kabsch, weighted`."""
    parts = (str(row[key]) for key in ("estimator", "stage", "variant"))
    return ", ".join(WORDS.get(part, part) for part in parts if part)


def markdown(rows: Sequence[Row], n: int, seconds: float, seed: int) -> str:
    """All studies: for each what J claims, a table of methods and one of points."""
    reference = "full interpolation, unweighted Kabsch or the real places of the lasers"
    text = CAPTION.format(n=n, seconds=seconds, seed=seed, reference=reference)
    parts = ["# Jansen et al. 2019: claims in simulated studies", text]
    for shown in SHOWN:
        own = [row for row in rows if row["study"] == shown.name]
        if own:
            parts += [f"## {shown.number}. {shown.title.capitalize()}", *_tables(shown, own)]
    return "\n\n".join(parts) + "\n"


def _tables(shown: Shown, rows: Sequence[Row]) -> list[str]:
    head = ["board m"] if shown.name == "lasers" else []
    overall = [[*head, "method", "r", "ratio", "claim", "finding"]]
    for row in first_of_methods(rows):
        pattern = [str(row["value"])] if isinstance(row["value"], str) else []
        cells = [
            ": ".join([method_text(row), *pattern]),
            _interval(row, "correlation_mm", 2),
            _interval(row, "overall_ratio", 3),
            str(row["claim"]),
            str(row["finding"]),
        ]
        overall.append([*([f"{row['board_m']:g}"] if head else []), *cells])
    unit = f" {shown.unit}" if shown.unit else ""
    points = [
        [
            *(*head, "method", f"{shown.parameter}{unit}", "error mm", "error °", "ratio"),
            *("failed", "beyond 8°", "mirrored %"),
        ]
    ]
    for row in rows:
        cells = [
            method_text(row),
            _value(row["value"]),
            _interval(row, "median_mm", 3, "mm"),
            _interval(row, "median_deg", 2, "deg"),
            _interval(row, "ratio", 3),
            f"{row['failed']} of {row['n']}",
            f"{row['beyond_8_deg']} of {row['n']}",
            "" if math.isnan(row["mirrored_percent"]) else f"{row['mirrored_percent']:.0f}",
        ]
        points.append([*([f"{row['board_m']:g}"] if head else []), *cells])
    return ["\n".join(aligned(overall)), "\n".join(aligned(points))]


def _value(value: object) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def _interval(row: Row, name: str, digits: int, unit: str = "") -> str:
    """`1.23 (1.02 to 1.50)`."""
    value, *ends = (row[key] for key in (name, f"lower_{unit or name}", f"upper_{unit or name}"))
    if math.isnan(value):
        return ""
    text = significant(value, digits)
    if any(map(math.isnan, ends)):
        return text
    return f"{text} ({significant(ends[0], digits)} to {significant(ends[1], digits)})"
