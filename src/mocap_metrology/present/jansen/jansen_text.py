"""Tables I, II and III of J as a person reads them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.common.types import Record
from mocap_metrology.lighthouse import published
from mocap_metrology.lighthouse.published import QUANTITIES, RECORDINGS, SETUPS
from mocap_metrology.papers.jansen import FACTOR, LAST, Variant, paper_setup, pose_of
from mocap_metrology.present.tables import Part, Row, document
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import significant

PHASES, SHORT_PATH = "rotor phases not modelled", "short path"
MEANINGS = {
    PHASES: (
        "ideal optics do not include the phases of the rotors, which rotate a station by 1 to "
        "3°; this is 50 to 160 mm at 3 m"
    ),
    SHORT_PATH: (
        "Kabsch estimates the slave's rotation from positions alone, and its errors grow with "
        "the ratio of distance to path length"
    ),
}
OTHERS = "places, paths and lasers of these stations are not those of J"
BESIDE = ("paper", "paper-lm", "batch")
MIRRORED = 0.05
HEAD = ("x mm", "y mm", "z mm", "α °", "β °", "γ °")
TITLES = {1: "mean absolute error", 2: "standard deviation", 3: "simulation"}
CAPTIONS = captions.texts("JANSEN_TABLES")

SIDE_BY_SIDE = "Stage final, of each estimator with factory values where it was run with them."


def markdown(number: int, rows: Sequence[Row], records: Sequence[Record], note: str = "") -> str:
    """Markdown of `jansen_table` or `jansen_table_3`: all variants in one table, what differs by
    more than a factor of four and why, then each variant by setup. note: of the sources."""
    title = f"Jansen et al. 2019, Table {'I' * number}: {TITLES[number]}"
    caption = CAPTIONS[str(number)], captions.JANSEN_COMMON, published.NOTES[number], note
    parts: list[Part] = [" ".join(filter(None, caption))]
    if number == 3:
        return document(title, *parts, *_simulation(rows))
    last = LAST[number]
    parts += [f"## {last}", _summary(rows, last)]
    if number == 2:
        parts.append(_caution([row["n"] for row in rows if row["setup"] != last]))
    parts.append(_explained(rows, last))
    if number == 1:
        parts.append(gain([r for r in records if paper_setup(r["setup"])]))
        parts.append(captions.JANSEN_ANGLES if any(row["n"] for row in rows) else "")
    by_variant = {
        v: of_variant
        for v, of_variant in _by_variant(rows).items()
        if any(row["n"] for row in of_variant)
    }
    parts += _stage_columns(by_variant, last)
    parts += ["## By setup", "Regenerated, in brackets published."]
    for variant, of_variant in by_variant.items():
        cells = {(row["setup"], row["quantity"]): row for row in of_variant}
        table = [["setup", *HEAD, "n"]]
        for setup in (*SETUPS, last):
            of = [cells[setup, q] for q in QUANTITIES]
            texts = [f"{significant(r['regenerated'])} ({r['published']:g})".lstrip() for r in of]
            table.append([setup, *texts, str(of[0]["n"])])
        parts += [f"### {variant}", table]
    return document(title, *parts)


def _simulation(rows: Sequence[Row]) -> list[Part]:
    parts: list[Part] = []
    for noise in dict.fromkeys(row["noise"] for row in rows):
        of_noise = [row for row in rows if row["noise"] == noise]
        n, setups = (max((row[key] for row in of_noise), default=0) for key in ("n", "n_setups"))
        counts = f"{_counted(setups, 'setup')}, {_counted(n, 'calibration')}"
        parts.append(f"## Noise: {noise} ({counts})")
        for last in (published.MAE, published.AVERAGE_SD):
            parts += [f"### {last}", _summary(of_noise, last)]
            if last == published.AVERAGE_SD:
                parts.append(_caution([n // setups] if setups else []))
            parts.append(_explained(of_noise, last, ideal_rotors=True))
    return parts


def _by_variant(rows: Sequence[Row]) -> dict[Variant, list[Row]]:
    groups: dict[Variant, list[Row]] = {}
    for row in rows:
        variant = Variant(row["estimator"], row["stage"], row["optics"])
        groups.setdefault(variant, []).append(row)
    return groups


def _summary(rows: Sequence[Row], last: str) -> list[list[str]]:
    """One line a variant, the published one first; in brackets regenerated over published."""
    of_setup = [row for row in rows if row["setup"] == last]
    printed = {row["quantity"]: row["published"] for row in of_setup}
    table = [["estimator", "stage", "optics", *HEAD, "mirrored", "n"]]
    table.append(["published", "", "", *(significant(printed.get(q)) for q in QUANTITIES), "", ""])
    for variant, of_it in _by_variant(of_setup).items():
        share, n = of_it[0]["mirrored_share"], of_it[0]["n"]
        percent = "" if math.isnan(share) else f"{100 * share:.2g} %"
        table.append([*vars(variant).values(), *map(_with_ratio, of_it), percent, str(n)])
    return table


def _with_ratio(row: Row) -> str:
    ratio = float(f"{row['ratio']:.2g}")
    return f"{significant(row['regenerated'])} (×{ratio:g})" if math.isfinite(ratio) else ""


def _counted(n: int, noun: str) -> str:
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def _caution(counts: Sequence[int]) -> str:
    """Uncertainty of an SD from so few calibrations; nothing if J has as few."""
    from scipy.special import chdtri

    n = min((count for count in counts if count > 1), default=RECORDINGS)
    if n >= RECORDINGS:
        return ""
    low, high = (math.sqrt(chdtri(n - 1, p) / (n - 1)) for p in (0.975, 0.025))
    return captions.JANSEN_CAUTION.format(n=n, of_paper=RECORDINGS, low=low, high=high)


def _stage_columns(by_variant: Mapping[Variant, Sequence[Row]], last: str) -> list[Part]:
    """Published and the final stage of `BESIDE` in columns, a row a setup; of each estimator with
    factory values, where it has been run with these."""
    shown = {}
    for name in BESIDE:
        finals = [v for v in by_variant if (v.estimator, v.stage) == (name, "final")]
        if finals:
            best = next((v for v in finals if v.optics == "factory"), finals[0])
            shown[best] = {(row["setup"], row["quantity"]): row for row in by_variant[best]}
    if not shown:
        return []
    columns = [("published", next(iter(shown.values())))]
    columns += [("regenerated", cells) for cells in shown.values()]
    parts: list[Part] = ["## Estimators side by side", SIDE_BY_SIDE]
    for part in (slice(3), slice(3, 6)):
        title = " / ".join(one.split()[0] for one in HEAD[part]) + f" {HEAD[part][0].split()[1]}"
        table = [[title, "published", *(f"{v.estimator}, {v.optics}" for v in shown)]]
        for setup in (*SETUPS, last):
            if any(np.isfinite(c[setup, "x_mm"]["regenerated"]) for c in shown.values()):
                values = [[c[setup, q][key] for q in QUANTITIES[part]] for key, c in columns]
                table.append([setup, *(" / ".join(map(significant, v)) for v in values)])
        parts.append(table)
    return parts


def _explained(rows: Sequence[Row], last: str, ideal_rotors: bool = False) -> str:
    """A line for the variants with the same values beyond the factor: which, and why."""
    larger: dict[str, list[str]] = {}
    smaller = []
    for variant, of_variant in _by_variant([r for r in rows if r["setup"] == last]).items():
        which = [
            HEAD[QUANTITIES.index(r["quantity"])][0] for r in of_variant if r["ratio"] > FACTOR
        ]
        if which:
            why = reason(variant, of_variant[0]["mirrored_share"], ideal_rotors)
            text = f"{', '.join(which)} above {FACTOR:g} times the published value: {why}."
            larger.setdefault(text, []).append(str(variant))
        if any(r["ratio"] < 1 / FACTOR for r in of_variant):
            smaller.append(str(variant))
    lines = [f"- {'; '.join(variants)}: {text}" for text, variants in larger.items()]
    for cause, meaning in MEANINGS.items():
        if any(cause in text for text in larger):
            lines.append(f"- {cause.capitalize()}: {meaning}.")
    if smaller:
        names = "; ".join(smaller)
        lines.append(f"- Below a quarter of the published value in some column: {names}.")
    return "\n".join(lines)


def reason(variant: Variant, mirrored: float, ideal_rotors: bool = False) -> str:
    """Why errors are far above the published ones, as far as it can be determined.

    ideal_rotors: the recordings have no factory errors that optics could neglect.
    """
    causes = []
    if mirrored > MIRRORED:
        exact = variant.stage == "final" and variant.estimator != "paper-lm"
        last = " and the last minimisation assumes that their rotations are exact" * exact
        share = f"{100 * mirrored:.2g} % of the board poses are mirrored"
        causes.append(f"{share}, as J's may have been{last}")
    if variant.optics == "ideal" and not ideal_rotors:
        causes.append(PHASES)
    if variant.stage == "kabsch":
        causes.append(SHORT_PATH)
    return "; ".join(causes or [OTHERS])


def gain(records: Sequence[Record]) -> str:
    """The factor by which factory values reduce the errors of `paper-lm`, over calibrations that
    have both."""
    ideal, factory = (Variant("paper-lm", "final", optics) for optics in ("ideal", "factory"))
    each = [(pose_of(r, ideal), pose_of(r, factory)) for r in records]
    pairs = [(a, b) for a, b in each if a is not None and b is not None]
    if not pairs:
        return ""
    optical = all("truth_errors_mm" in pose for pair in pairs for pose in pair)
    before = "truth_" if optical else ""
    mm, deg = (
        [float(np.mean([np.linalg.norm(pair[k][name]) for pair in pairs])) for k in (0, 1)]
        for name in (f"{before}errors_mm", f"{before}errors_deg")
    )
    frame = "between the optical frames of the twins" if optical else "against the reference"
    return (
        f"Factory values reduce the mean error of paper-lm, final, {frame} from "
        f"{significant(mm[0])} to {significant(mm[1])} mm ({mm[0] / mm[1]:.1f} times) and from "
        f"{significant(deg[0])} to {significant(deg[1])}° ({deg[0] / deg[1]:.1f} times; "
        f"{len(pairs)} calibrations)."
    )
