"""Reasons of a verdict: a check, and why numbers are measured, in words."""

from __future__ import annotations

from mocap_metrology.noise.assess.checks import LEAST_FRAMES, LEAST_S, Check, ModelCheck
from mocap_metrology.noise.assess.uncertainty import Unmodelled, Why
from mocap_metrology.present.text.numbers import with_unit
from mocap_metrology.present.text.sentence import render


def quantity(check: Check) -> str:
    """Name of the quantity that is compared with the limit."""
    return render(f"quantity.{check.code}", c=check)


def reason(check: Check) -> str:
    """The sentence of a check, with its numbers."""

    def limit(times: float = 1, unit: str = "mm") -> str:
        return render(f"limit.{check.word}", size=with_unit(times * float(check.limit), unit))

    return render(
        f"check.{check.code}",
        c=check,
        names=", ".join(check.names),
        limit=limit,
        reasons=_series_by_reason(check) if isinstance(check, ModelCheck) else {},
        least_frames=LEAST_FRAMES,
        least_s=LEAST_S,
    )


def why_measured(unmodelled: Unmodelled | None) -> str:
    """Why the numbers of a series are not those of a model; empty where they are."""
    return render(f"measured.{unmodelled.why}", **vars(unmodelled)) if unmodelled else ""


def _series_by_reason(check: ModelCheck) -> dict[str, list[str]]:
    """Series by why they have no noise model."""
    none = why_measured(Unmodelled(Why.NO_MODEL))
    series: dict[str, list[str]] = {}
    for name, one in check.unmodelled.items():
        words = why_measured(one)
        if one is not None and one.why not in (Why.NO_MODEL, Why.MISFIT):
            words = f"{none} ({words})"
        series.setdefault(words or none, []).append(name)
    return series
