"""The verdict on a recording in words: lines for a terminal, a row of the group's table."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

from mocap_metrology.common.types import Record, Row
from mocap_metrology.noise.assess.checks import COORDINATE, LEAST_FRAMES, LEAST_S, Check, ModelCheck
from mocap_metrology.noise.assess.mean import NOT_COVERED
from mocap_metrology.noise.assess.recording import Assessment
from mocap_metrology.noise.assess.uncertainty import Reason, SeriesNumbers, Unmodelled
from mocap_metrology.noise.fit.estimates import correlation_class
from mocap_metrology.present.accuracy.bar import bar_lines
from mocap_metrology.present.tables import in_columns
from mocap_metrology.present.text.numbers import duration_words, significant, with_unit
from mocap_metrology.present.text.sentence import render

# Kinds of findings that a check of the verdict states as well
STATED = {
    "missing": ("filled", "gaps"),
    "missing_or_filled": ("filled", "gaps"),
    "low_pass": ("low_pass",),
    "outliers": ("outliers",),
    "step": ("resolution",),
    "moves": ("moving",),
}
# Names of the quantities, in the order of the figure
FRAME, NEAR = "one frame", "one frame within 1 s"
MEANS = ("mean of 1 s", "mean of 10 s", "mean of 60 s")
MOST_ROWS = 24  # of a table on the terminal, and of the figure
OF_MEAN = ("duration_s", "adev_mm", "uncertainty_mm", "lower_mm", "upper_mm", "measured_mm",
           "shares")  # fmt: skip


def summary_row(verdict: Record) -> Row:
    """A row of <group>_summary. verdict: contents of verdict.json, as everywhere here."""
    series = {k: v for k, v in verdict["series"].items() if COORDINATE.fullmatch(k)}
    name = _greatest({k: v["frame_mm"] for k, v in series.items()})
    worst = series.get(name, {})
    means = [{k: v["means"][n]["uncertainty_mm"] for k, v in series.items()} for n in range(3)]
    largest = [sizes.get(_greatest(sizes)) for sizes in means]
    sigma = {k: v["sigma_frame_mm"] for k, v in series.items()}
    return {
        "recording": verdict["recording"],
        "source": verdict["source"],
        "word": verdict["word"],
        "reason": verdict["reason"],
        "worst": name,
        "sigma_frame_mm": sigma.get(_greatest(sigma)),
        "sigma_frame_L_mm": verdict["series"].get("L", {}).get("sigma_frame_mm"),
        "frame_mm": worst.get("frame_mm"),
        "adev_min_mm": worst.get("adev_min_mm"),
        "tau_min_s": worst.get("tau_min_s"),
        **dict(zip(("mean_1_s_mm", "mean_10_s_mm", "mean_60_s_mm"), largest, strict=True)),
        "reference_for_4x_mm": verdict["reference_for_mm"]["4"],
        "reference_for_10x_mm": verdict["reference_for_mm"]["10"],
        "dominating_noise": _greatest(worst["shares"]) if worst else "",
        "horizon_s": verdict["horizon_s"],
        "n_findings": len(verdict["bar"]["findings"] if "bar" in verdict else _warnings(verdict)),
    }


def _greatest(values: Mapping[str, float | None]) -> str:
    """Name of the greatest value; empty where none is known."""
    known = {k: v for k, v in values.items() if v is not None}
    return max(known, key=lambda k: known[k], default="")


def _warnings(verdict: Record) -> list[Record]:
    """What the diagnosis warns of; what it only remarks stays in its own files."""
    return [item for item in verdict["sentences"] if item["severity"] != "info"]


def reference_sentence(verdict: Record) -> str:
    """S 2.2's rule with this recording's numbers, which are of noise only."""
    four, ten = (verdict["reference_for_mm"][k] for k in ("4", "10"))
    if four is None or math.isnan(four):
        return render("verdict.no_reference")
    return render("verdict.reference", four=four, ten=ten)


def marker_numbers(verdict: Record) -> list[str]:
    """Which marker has which number in the names of series, where that is known."""
    labels = verdict.get("labels")
    return [render("verdict.markers", labels=labels)] if labels else []


def sentences(verdict: Record) -> list[str]:
    """The reason, the number if it is not in it, what else was found, and what follows."""
    if bar := verdict.get("bar"):
        return [bar["reason"], *bar["sentences"]]
    number = [verdict["uncertainty"]] if verdict.get("uncertainty") else []
    caps = [cap["reason"] for cap in verdict["caps"]]
    return [verdict["reason"], *number, *caps, reference_sentence(verdict)]


def verdict_lines(verdict: Record) -> list[str]:
    """What `make check` prints of a recording; of one that moves no noise, which would be of the
    movement."""
    if bar := verdict.get("bar"):
        return bar_lines(bar)
    first = f"{verdict['recording']}: {verdict['word']}"
    if verdict["decided_by"]["code"] == "moves":
        return [first, verdict["reason"], reference_sentence(verdict)]
    horizon = duration_words(verdict["horizon_s"])
    head = f"Standard uncertainties in mm, about the mean of {horizon}:"
    lines = [first, *sentences(verdict), *marker_numbers(verdict), "", head]
    shown = {name: verdict["series"][name] for name in shown_series(verdict)}
    lines += [*in_columns(_table(shown)), *left_out(verdict), *_measured(verdict)]
    means = in_columns(mean_table(shown)) if has_mean(verdict) else []
    lines += ["", mean_words(verdict), *means]
    findings = [item["words"] for item in _warnings(verdict) if not is_stated(item, verdict)]
    lines += ["", "Findings:", *(f"  {words}" for words in findings)] if findings else []
    told = {item["words"].casefold().rstrip(".") for item in _warnings(verdict)}
    others = (w for w in verdict["warnings"] if w.casefold().rstrip(".") not in told)
    return [*lines, *(f"warning: {words}" for words in others)]


def shown_series(verdict: Record) -> list[str]:
    """The series that there is room for, in their order: the one that decided, and those with the
    largest uncertainty of one frame."""
    series, deciding = verdict["series"], verdict["decided_by"].get("series")
    largest = sorted(
        series, key=lambda name: (name != deciding, -(series[name]["frame_mm"] or 0.0))
    )
    return [name for name in series if name in largest[:MOST_ROWS]]


def left_out(verdict: Record) -> list[str]:
    """How many series there was no room for, if any."""
    n = len(verdict["series"]) - MOST_ROWS
    return [render("verdict.left_out", n=n)] if n > 0 else []


def mean_words(verdict: Record) -> str:
    """What `mean_table` is of, and what is not in it, or why there is no mean."""
    named = {name: verdict[name] for name in ("mean_mm", "not_covered")}
    return render("verdict.mean" if has_mean(verdict) else "verdict.no_mean", **named)


def has_mean(verdict: Record) -> bool:
    """Whether the mean of all frames of any series is known."""
    return any(one["mean_of_all"]["u_mm"] is not None for one in verdict["series"].values())


def mean_table(series: Mapping[str, Record]) -> list[list[str]]:
    """A row a series, with its head; a dash where the mean depends on when it is taken."""
    rows = [["", "u", "k", "k u", "independent frames (95 %)", "T_c", "length needed"]]
    for name, values in series.items():
        mean = values["mean_of_all"]
        n_eff, low, high = (
            significant(mean[f"n_eff{end}"]) for end in ("", "_lower_95", "_upper_95")
        )
        k, T_c, length = (significant(mean[of]) or "-" for of in ("k", "correlation_s", "length_s"))
        frames = f"{n_eff} ({low} to {high})" if n_eff else "-"
        sizes = _in_mm(mean["u_mm"]), k, _in_mm(mean["expanded_mm"])
        rows.append([name, *sizes, frames, T_c, length])
    return rows


def is_stated(item: Record, verdict: Record) -> bool:
    """Whether a warning of the diagnosis repeats a reason: one alone of its kind, or of series
    that have no noise model, as the reasons say."""
    codes = [check["code"] for check in (verdict["decided_by"], *verdict["caps"])]
    if item["kind"] == "misfit":
        return all(verdict["series"][name]["status"] == "refused" for name in item["series"])
    alone = sum(one["kind"] == item["kind"] for one in _warnings(verdict)) == 1
    return alone and any(item["kind"] in STATED.get(code, ()) for code in codes)


def _measured(verdict: Record) -> list[str]:
    """Which series have measured and no modelled numbers, and why, unless stated elsewhere."""
    reasons: dict[str, list[str]] = {}
    for name, values in verdict["series"].items():
        reasons.setdefault(values["why_measured"], []).append(name)
    if len(reasons) == 1 and (why := next(iter(reasons))):
        stated = why.casefold() in " ".join(sentences(verdict)).casefold()
        return ["", f"All measured, not modelled{'' if stated else f': {why}'}."]
    lines = [f"  {', '.join(names)}: {why}" for why, names in reasons.items() if why]
    return ["", "Measured, not modelled:", *lines] if lines else []


def _table(series: Mapping[str, Record]) -> list[list[str]]:
    """A row a series with its uncertainties, the lowest Allan deviation, and the largest kind of
    noise, where any is known."""
    rows = [["", FRAME, NEAR, *MEANS, "lowest ADEV", "mostly"]]
    for name, values in series.items():
        least, kind = _in_mm(values["adev_min_mm"]), _greatest(values["shares"])
        if values["adev_min_mm"] is not None:
            falls = ", still falling" if values["adev_still_falls"] else ""
            least = f"{least}{falls} at {significant(values['tau_min_s'])} s"
        means = [_in_mm(mean["uncertainty_mm"]) for mean in values["means"]]
        mostly = f"{kind} {100 * values['shares'][kind]:.0f} %" if kind else ""
        sizes = [_in_mm(values["frame_mm"]), _in_mm(values["sigma_frame_mm"]), *means]
        rows.append([name, *sizes, least, mostly])
    return rows if any(row[-1] for row in rows[1:]) else [row[:-1] for row in rows]


def _in_mm(value: float | None) -> str:
    """Three digits, or a dash for nothing."""
    return significant(value, least=1e-6) or "-"


def verdict_document(assessment: Assessment, source: str) -> Row:
    """Numbers and words of an assessment. source: `twin` or `measured`."""
    facts, span, verdict = assessment.facts, assessment.span, assessment.verdict
    return {
        "source": source,
        "labels": list(facts.labels),
        "duration_s": facts.duration_s,
        "frame_rate_hz": span.frame_rate_hz,
        "horizon_s": facts.horizon_s,
        "window_s": span.window_s,
        "confidence": span.confidence,
        "word": verdict.word,
        "reason": reason(verdict.decided_by),
        "decided_by": _check(verdict.decided_by),
        "caps": [_check(c) | {"word": c.word, "reason": reason(c)} for c in verdict.caps],
        "uncertainty": reason(verdict.uncertainty) if verdict.uncertainty else "",
        "reference_for_mm": verdict.reference_for_mm,
        "mean_mm": span.mean_mm,
        "not_covered": list(NOT_COVERED),
        "limits_mm": {"good": assessment.limits.good_mm, "usable": assessment.limits.usable_mm},
        "series": {
            name: _series(numbers)
            | {"missing": facts.missing.get(name), "excess_outliers": facts.outliers.get(name)}
            for name, numbers in assessment.series.items()
        },
    }


def verdict_of_bar(bar: Record) -> Row:
    """What verdict.json has of a bar that is moved instead of noise; bar: contents of bar.json."""
    empty = {"series": "", "value": bar["size_mm"], "limit": bar["limits_mm"]["usable"]}
    decided = {"code": "bar", "quantity": "errors of a moving bar", "unit": "mm"}
    return {
        **{key: bar[key] for key in ("source", "frame_rate_hz", "duration_s")},
        **{key: bar[key] for key in ("word", "reason", "warnings", "not_covered")},
        **{"labels": bar["pair"], "horizon_s": None},
        **{"caps": [], "uncertainty": "", "series": {}, "sentences": [], "findings": []},
        "decided_by": decided | empty,
        "limits_mm": bar["limits_mm"],
        "reference_for_mm": {"4": None, "10": None},
        "bar": bar,
    }


def _check(check: Check) -> Row:
    return {
        "code": str(check.code),
        "threshold": check.threshold,
        "series": check.series,
        "quantity": render(f"quantity.{check.code}", c=check),
        "value": check.value,
        "limit": check.limit,
        "unit": check.unit,
    }


def reason(check: Check) -> str:
    """The sentence of a check, with its numbers."""

    def limit(times: float = 1, unit: str = "mm") -> str:
        return render(f"limit.{check.word}", size=with_unit(times * float(check.limit), unit))

    none = why_measured(Unmodelled(Reason.NO_MODEL))
    series: dict[str, list[str]] = {}  # by why they have no noise model
    unmodelled = check.unmodelled if isinstance(check, ModelCheck) else {}
    for name, one in unmodelled.items():
        why = why_measured(one, unmodelled.values()) or none
        bare = one is None or one.why in (Reason.NO_MODEL, Reason.MISFIT)
        series.setdefault(why if bare else f"{none} ({why})", []).append(name)
    names, least = ", ".join(check.names), {"least_frames": LEAST_FRAMES, "least_s": LEAST_S}
    return render(f"check.{check.code}", c=check, names=names, limit=limit, reasons=series, **least)


def why_measured(unmodelled: Unmodelled | None, others: Collection[Unmodelled | None] = ()) -> str:
    """Why the numbers of a series are not those of a model; empty where they are. others: series
    told together with it, so that their numbers of samples are given as a range."""
    if unmodelled is None:
        return ""
    alike = [one.value for one in others if one is not None and one.why == unmodelled.why]
    ends = {"least": min(alike, default=unmodelled.value), "most": max(alike, default=math.nan)}
    return render(f"measured.{unmodelled.why}", **vars(unmodelled), **ends)


def _series(numbers: SeriesNumbers) -> Row:
    """All its numbers, and in words why they are measured."""
    row = vars(numbers) | {
        "why_measured": why_measured(numbers.unmodelled),
        "means": [{name: getattr(mean, name) for name in OF_MEAN} for mean in numbers.means],
        "shares": numbers.shares,
        "kinds": [vars(one) | {"class": _class(one.T_c_s)} for one in numbers.kinds],
        "mean_of_all": vars(numbers.mean_of_all),
    }
    del row["unmodelled"]
    return row


def _class(T_c_s: float) -> str:
    """The class of correlated noise (S 4.6)."""
    return "" if math.isnan(T_c_s) else correlation_class(T_c_s)
