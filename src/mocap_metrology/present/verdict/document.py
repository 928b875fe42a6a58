"""Contents of verdict.json."""

from __future__ import annotations

from mocap_metrology.common.types import Row
from mocap_metrology.noise.assess.checks import Check
from mocap_metrology.noise.assess.mean import NOT_COVERED
from mocap_metrology.noise.assess.recording import Assessment
from mocap_metrology.noise.assess.uncertainty import Mean, SeriesNumbers
from mocap_metrology.present.text.reasons import quantity, reason, why_measured

AFTER_REASON = (
    *("sigma_frame_mm", "sigma_frame_lower_mm", "sigma_frame_upper_mm", "sigma_recording_mm"),
    *("frame_mm", "frame_lower_mm", "frame_upper_mm", "adev_min_mm", "adev_min_lower_mm"),
    *("adev_min_upper_mm", "tau_min_s", "adev_still_falls"),
)
OF_MEAN = ("duration_s", "adev_mm", "uncertainty_mm", "lower_mm", "upper_mm", "measured_mm")


def verdict_document(found: Assessment, source: str) -> Row:
    """Numbers and words of an assessment. source: `twin` or `measured`."""
    facts, span, verdict = found.facts, found.span, found.verdict
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
        "limits_mm": {"good": found.limits.good_mm, "usable": found.limits.usable_mm},
        "series": {
            name: _series(numbers)
            | {"missing": facts.missing.get(name), "excess_outliers": facts.outliers.get(name)}
            for name, numbers in found.series.items()
        },
    }


def _check(check: Check) -> Row:
    return {
        "threshold": check.threshold,
        "series": check.series,
        "quantity": quantity(check),
        "value": check.value,
        "limit": check.limit,
        "unit": check.unit,
    }


def _series(numbers: SeriesNumbers) -> Row:
    return {
        "status": numbers.status,
        "basis": numbers.basis,
        "why_measured": why_measured(numbers.unmodelled),
        **{name: getattr(numbers, name) for name in AFTER_REASON},
        "means": [_mean(mean) for mean in numbers.means],
        "shares": dict(numbers.shares),
        "floor_mm": numbers.floor_mm,
        "drift_mm_per_h": numbers.drift_mm_per_h,
        "range_mm": numbers.range_mm,
        "mean_of_all": vars(numbers.mean_of_all),
    }


def _mean(mean: Mean) -> Row:
    return {**{name: getattr(mean, name) for name in OF_MEAN}, "shares": dict(mean.shares)}
