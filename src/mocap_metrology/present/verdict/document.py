"""Contents of verdict.json."""

from __future__ import annotations

import math

from mocap_metrology.common.types import Row
from mocap_metrology.noise.assess.checks import Check
from mocap_metrology.noise.assess.mean import NOT_COVERED
from mocap_metrology.noise.assess.recording import Assessment
from mocap_metrology.noise.assess.spread import Share
from mocap_metrology.noise.assess.uncertainty import SeriesNumbers
from mocap_metrology.noise.fit.estimates import correlation_class
from mocap_metrology.present.text.reasons import quantity, reason, why_measured

NUMBERS = (  # of a series
    *("sigma_frame_mm", "sigma_frame_lower_mm", "sigma_frame_upper_mm", "sigma_recording_mm"),
    *("frame_mm", "frame_lower_mm", "frame_upper_mm", "adev_min_mm", "adev_min_lower_mm"),
    *("adev_min_upper_mm", "tau_min_s", "adev_still_falls"),
)
OF_MEAN = (
    *("duration_s", "adev_mm", "uncertainty_mm", "lower_mm", "upper_mm", "measured_mm", "shares"),
)


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


def _check(check: Check) -> Row:
    numbers = {name: getattr(check, name) for name in ("value", "limit", "unit")}
    named = {"threshold": check.threshold, "series": check.series, "quantity": quantity(check)}
    return named | numbers | {"code": str(check.code)}


def _series(numbers: SeriesNumbers) -> Row:
    return {
        "status": numbers.status,
        "basis": numbers.basis,
        "why_measured": why_measured(numbers.unmodelled),
        **{name: getattr(numbers, name) for name in NUMBERS},
        "means": [{name: getattr(mean, name) for name in OF_MEAN} for mean in numbers.means],
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
    return {"kind": one.kind, "class": of_time} | {
        k: v for k, v in vars(one).items() if k != "kind"
    }
