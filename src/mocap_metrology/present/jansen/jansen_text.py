"""Tables I, II and III of J as a person reads them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TypeVar

import numpy as np

from mocap_metrology.lighthouse.published import (
    AVERAGE,
    AVERAGE_SD,
    MAE,
    NOTES,
    OVERALL,
    QUANTITIES,
    RECORDINGS,
    SETUPS,
)
from mocap_metrology.present.jansen.jansen_tables import Variant, paper_setup, pose_of
from mocap_metrology.present.tables import Record, Row, aligned
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
FACTOR = 4.0  # beyond it a regenerated value is explained
MIRRORED = 0.05
HEAD = ("x mm", "y mm", "z mm", "α °", "β °", "γ °")
TITLES = {
    1: "mean absolute error",
    2: "standard deviation",
    3: "simulation",
}
CAPTIONS = {
    1: "Mean absolute error of the calibrations of each setup against the reference; Overall is the"
    " mean of the setups.",
    2: "Standard deviation (n - 1) of the errors of each setup; Average is the mean of the setups."
    " A setup with fewer than two calibrations has none: its cells are empty.",
    3: "Simulated setups: mean absolute error, and standard deviation (n - 1) of each, averaged."
    " J simulates the error of samples alone (quantisation at 2 MHz); with jitter means 53 urad"
    " common to a sweep and 30 urad of each diode on top.",
}
COMMON = (
    "Errors are t - t_true in the master's frame and the rotation vector of R R_true^T in deg. "
    "paper: simplex with MATLAB's settings; paper-tight: with tight tolerances and started from "
    "the previous pose; paper-lm: Levenberg-Marquardt with the mirror test, cubic interpolation "
    "and a last minimisation with weights for what the path leaves uncertain (config: "
    "lm_interpolation, lm_weights); batch: all hits at their own times in one estimate. kabsch: "
    "before the last minimisation (K₂), final: after it. "
    "J used ideal optics and does not state the settings of the search. Mirrored: share of board "
    "poses in the wrong one of the two minima of a flat board."
)


ANGLES = (
    "An angle error of the optics moves the slave by angle times distance: at 2 to 6 m the "
    "published 1.2 to 1.8° would be 40 to 190 mm, but 20 to 29 mm are published. Part of J's "
    "angle errors may therefore come from the mounts: a mount rotated on its housing causes such "
    "errors without a change of position. The mounts of the twins are straight."
)
K = TypeVar("K")


def markdown(number: int, rows: Sequence[Row], records: Sequence[Record], note: str = "") -> str:
    """Markdown of `jansen_table` or `jansen_table_3`: all variants in one table, what differs by
    more than a factor of four and why, then each variant by setup. note: of the sources."""
    lines = [f"# Jansen et al. 2019, Table {'I' * number}: {TITLES[number]}", ""]
    lines += [" ".join(filter(None, (CAPTIONS[number], COMMON, NOTES[number], note))), ""]
    if number == 3:
        for noise in dict.fromkeys(row["noise"] for row in rows):
            of_noise = [row for row in rows if row["noise"] == noise]
            n = max((row["n"] for row in of_noise), default=0)
            setups = max((row["n_setups"] for row in of_noise), default=0)
            counts = f"{_counted(setups, 'setup')}, {_counted(n, 'calibration')}"
            lines += [f"## Noise: {noise} ({counts})", ""]
            for last in (MAE, AVERAGE_SD):
                lines += [f"### {last}", "", *_summary(of_noise, last), ""]
                if last == AVERAGE_SD:
                    lines += _caution([n // setups] if setups else [])
                lines += _explained(of_noise, last, ideal_rotors=True)
        return "\n".join(lines)
    last = {1: OVERALL, 2: AVERAGE}[number]
    lines += [f"## {last}", "", *_summary(rows, last), ""]
    if number == 2:
        lines += _caution([row["n"] for row in rows if row["setup"] != last])
    lines += _explained(rows, last)
    gained = gain([r for r in records if paper_setup(r["setup"])]) if number == 1 else ""
    lines += [gained, ""] if gained else []
    lines += [ANGLES, ""] if number == 1 and any(row["n"] for row in rows) else []
    lines += _beside(rows, last)
    lines += ["## By setup", "", "Regenerated, in brackets published.", ""]
    for variant, own in _grouped(rows, _variant):
        if any(row["n"] for row in own):
            lines += [f"### {variant}", "", *_by_setup(own, last), ""]
    return "\n".join(lines)


def _variant(row: Row) -> Variant:
    return Variant(row["estimator"], row["stage"], row["optics"])


def _grouped(rows: Iterable[Row], key: Callable[[Row], K]) -> list[tuple[K, list[Row]]]:
    groups: dict[K, list[Row]] = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    return list(groups.items())


def _summary(rows: Sequence[Row], last: str) -> list[str]:
    """One line a variant, the published one first; in brackets regenerated over published."""
    own = [row for row in rows if row["setup"] == last]
    published = {row["quantity"]: row["published"] for row in own}
    table = [["estimator", "stage", "optics", *HEAD, "mirrored", "n"]]
    table.append(["published", "", "", *(significant(published.get(q)) for q in QUANTITIES)])
    table[-1] += ["", ""]
    for variant, of_it in _grouped(own, _variant):
        cells = {row["quantity"]: _with_ratio(row) for row in of_it}
        share, n = of_it[0]["mirrored_share"], of_it[0]["n"]
        percent = "" if math.isnan(share) else f"{100 * share:.2g} %"
        kind = [variant.estimator, variant.stage, variant.optics]
        table.append([*kind, *(cells[q] for q in QUANTITIES), percent, str(n)])
    return aligned(table)


def _with_ratio(row: Row) -> str:
    if math.isnan(row["regenerated"]):
        return ""
    ratio = float(f"{row['ratio']:.2g}")
    return f"{significant(row['regenerated'])} (×{ratio:g})"


def _counted(n: int, noun: str) -> str:
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def _caution(counts: Sequence[int]) -> list[str]:
    """Uncertainty of an SD from so few calibrations; nothing if J has as few."""
    from scipy.stats import chi2

    n = min((count for count in counts if count > 1), default=RECORDINGS)
    if n >= RECORDINGS:
        return []
    low, high = (math.sqrt(chi2.ppf(p, n - 1) / (n - 1)) for p in (0.025, 0.975))
    said = (
        f"An SD of {n} calibrations (J: {RECORDINGS}) is {low:.2g} to {high:.2g} times the true "
        "one (95 %, normal errors), and one failed calibration can dominate it: read the ratios "
        "as orders of magnitude."
    )
    return [said, ""]


def _beside(rows: Sequence[Row], last: str) -> list[str]:
    """Published and the final stage of `BESIDE` in columns, a row a setup; of each estimator with
    factory values, where it has been run with these."""
    found = {v: own for v, own in _grouped(rows, _variant) if any(row["n"] for row in own)}
    shown = {}
    for name in BESIDE:
        finals = [v for v in found if (v.estimator, v.stage) == (name, "final")]
        if finals:
            best = next((v for v in finals if v.optics == "factory"), finals[0])
            shown[best] = {(row["setup"], row["quantity"]): row for row in found[best]}
    lines: list[str] = []
    for quantities, head in ((QUANTITIES[:3], HEAD[:3]), (QUANTITIES[3:], HEAD[3:])):
        unit = head[0].split()[1]
        title = " / ".join(one.split()[0] for one in head) + f" {unit}"
        table = [[title, "published", *(f"{v.estimator}, {v.optics}" for v in shown)]]
        for setup in (s for s in (*SETUPS, last) if _calibrated(shown, s)):
            columns = [("published", next(iter(shown.values())))] if shown else []
            columns += [("regenerated", cells) for cells in shown.values()]
            values = [[cells[setup, q][key] for q in quantities] for key, cells in columns]
            table.append([setup, *(" / ".join(map(significant, v)) for v in values)])
        lines += [*aligned(table), ""]
    said = "Stage final, of each estimator with factory values where it was run with them."
    return ["## Estimators side by side", "", said, "", *lines] if shown else []


def _calibrated(shown: Mapping[Variant, Mapping[tuple[str, str], Row]], setup: str) -> bool:
    return any(np.isfinite(c[setup, QUANTITIES[0]]["regenerated"]) for c in shown.values())


def _by_setup(rows: Sequence[Row], last: str) -> list[str]:
    cells = {(row["setup"], row["quantity"]): row for row in rows}
    counts = {row["setup"]: row["n"] for row in rows}
    table = [["setup", *HEAD, "n"]]
    for setup in (*SETUPS, last):
        shown = [
            f"{significant(row['regenerated'])} ({row['published']:g})".lstrip()
            for row in (cells[setup, q] for q in QUANTITIES)
        ]
        table.append([setup, *shown, str(counts[setup])])
    return aligned(table)


def _explained(rows: Sequence[Row], last: str, ideal_rotors: bool = False) -> list[str]:
    """A line for the variants with the same values beyond the factor: which, and why."""
    said: dict[str, list[str]] = {}
    smaller = []
    for variant, own in _grouped([r for r in rows if r["setup"] == last], _variant):
        far = [r for r in own if r["ratio"] > FACTOR]
        if far:
            which = ", ".join(HEAD[QUANTITIES.index(r["quantity"])][0] for r in far)
            why = reason(variant, own[0]["mirrored_share"], ideal_rotors)
            text = f"{which} above {FACTOR:g} times the published value: {why}."
            said.setdefault(text, []).append(str(variant))
        if any(r["ratio"] < 1 / FACTOR for r in own):
            smaller.append(str(variant))
    lines = [f"- {'; '.join(variants)}: {text}" for text, variants in said.items()]
    lines += [
        f"- {cause.capitalize()}: {meaning}."
        for cause, meaning in MEANINGS.items()
        if any(cause in text for text in said)
    ]
    if smaller:
        lines.append(
            f"- Below a quarter of the published value in some column: {'; '.join(smaller)}."
        )
    return [*lines, ""] if lines else []


def reason(variant: Variant, mirrored: float, ideal_rotors: bool = False) -> str:
    """Why errors are far above the published ones, as far as it can be determined.

    ideal_rotors: the recordings have no factory errors that optics could neglect.
    """
    causes = []
    if mirrored > MIRRORED:
        last = (
            " and the last minimisation assumes that their rotations are exact"
            if variant.stage == "final" and variant.estimator != "paper-lm"
            else ""
        )
        share = f"{100 * mirrored:.2g} % of the board poses are mirrored"
        causes.append(f"{share}, as J's may have been{last}")
    if variant.optics == "ideal" and not ideal_rotors:
        causes.append(PHASES)
    if variant.stage == "kabsch":
        causes.append(SHORT_PATH)
    return "; ".join(causes or [OTHERS])


def gain(records: Sequence[Record], estimator: str = "paper-lm", stage: str = "final") -> str:
    """By what factor the factory values cut the errors, over calibrations that have both."""
    ideal, factory = (Variant(estimator, stage, optics) for optics in ("ideal", "factory"))
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
        f"Factory values reduce the mean error of {estimator}, {stage}, {frame} from "
        f"{significant(mm[0])} to {significant(mm[1])} mm ({mm[0] / mm[1]:.1f} times) and from "
        f"{significant(deg[0])} to {significant(deg[1])}° ({deg[0] / deg[1]:.1f} times; "
        f"{len(pairs)} calibrations)."
    )
