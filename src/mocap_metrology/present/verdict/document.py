"""Contents of verdict.json: the numbers and the reasons of an assessment."""

from __future__ import annotations

import math
from collections.abc import Collection

from mocap_metrology.common.types import Row
from mocap_metrology.noise.assess.checks import LEAST_FRAMES, LEAST_S, Check, ModelCheck
from mocap_metrology.noise.assess.mean import NOT_COVERED
from mocap_metrology.noise.assess.recording import Assessment
from mocap_metrology.noise.assess.spread import Share
from mocap_metrology.noise.assess.uncertainty import SeriesNumbers, Unmodelled, Why
from mocap_metrology.noise.fit.estimates import correlation_class
from mocap_metrology.present.tables import Record
from mocap_metrology.present.text.numbers import with_unit
from mocap_metrology.present.text.sentence import render

NUMBERS = (  # of a series
    *("sigma_frame_mm", "sigma_frame_lower_mm", "sigma_frame_upper_mm", "sigma_recording_mm"),
    *("frame_mm", "frame_lower_mm", "frame_upper_mm", "adev_min_mm", "adev_min_lower_mm"),
    *("adev_min_upper_mm", "tau_min_s", "adev_still_falls"),
)
OF_MEAN = ("duration_s", "adev_mm", "uncertainty_mm", "lower_mm", "upper_mm", "measured_mm")


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

    none = why_measured(Unmodelled(Why.NO_MODEL))
    series: dict[str, list[str]] = {}  # by why they have no noise model
    unmodelled = check.unmodelled if isinstance(check, ModelCheck) else {}
    for name, one in unmodelled.items():
        why = why_measured(one, unmodelled.values()) or none
        bare = one is None or one.why in (Why.NO_MODEL, Why.MISFIT)
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
    means = [{name: getattr(mean, name) for name in (*OF_MEAN, "shares")} for mean in numbers.means]
    return {
        "status": numbers.status,
        "basis": numbers.basis,
        "why_measured": why_measured(numbers.unmodelled),
        **{name: getattr(numbers, name) for name in NUMBERS},
        "means": means,
        "shares": numbers.shares,
        "kinds": [_kind(one) for one in numbers.kinds],
        "floor_mm": numbers.floor_mm,
        "drift_mm_per_h": numbers.drift_mm_per_h,
        "range_mm": numbers.range_mm,
        "mean_of_all": vars(numbers.mean_of_all),
    }


def _kind(one: Share) -> Row:
    """A kind of noise with its share; class: of correlated noise (S 4.6)."""
    of_time = "" if math.isnan(one.T_c_s) else correlation_class(one.T_c_s)
    return {**vars(one), "class": of_time}
