"""What an export did to the numbers before anyone could judge them: its steps, its filters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from mocap_metrology.common.words import three
from mocap_metrology.noise.assess.facts import Check, Facts, Thresholds

Series = Mapping[str, Mapping[str, Any]]


def measured(coordinates: Series, facts: Facts) -> Series:
    """Coordinates whose numbers are of a measurement: without those that lie within one step of
    the file all the time, where others pass from step to step."""
    coarse = facts.found("resolution_limited")
    constant = [k for k, v in coordinates.items() if v["status"] == "constant" and k in coarse]
    if all(k in constant for k in coarse):
        return coordinates
    return {k: v for k, v in coordinates.items() if k not in constant}


def resolution_check(coordinates: Series, facts: Facts, limits: Thresholds) -> Check:
    """Never better than usable: where in a step a marker is decides on all numbers below a step,
    and the step is all that is known of them."""
    coarse = {k: v for k, v in facts.found("resolution_limited").items() if k in coordinates}
    step = max(coarse.values(), default=math.nan)
    word = "good" if not coarse else "usable" if step <= limits.usable_mm else "bad"
    named = ", ".join(coarse) if len(coarse) < len(coordinates) else "all coordinates"
    sentence = (
        f"The resolution of the export decides: its steps of {three(step)} mm hide the noise of "
        f"{named}, so a frame is known to a step and not better; export finer steps."
    )
    key, quantity = "verdict.usable_mm", "step of the file"
    name = next(iter(coarse), "")
    return Check(key, name, quantity, step, limits.usable_mm, "mm", word, sentence)


def filter_check(coordinates: Series, facts: Facts) -> Check:
    """Of filtered data no word is better than usable: what a frame scattered by is gone."""
    cutoffs = {k: v for k, v in facts.found("low_pass").items() if k in coordinates}
    known = sorted(v for v in cutoffs.values() if math.isfinite(v))
    about = f" at about {known[len(known) // 2]:.2g} Hz" if known else ""
    named = ", ".join(cutoffs) if len(cutoffs) < len(coordinates) else "The recording"
    verb = "look" if 1 < len(cutoffs) < len(coordinates) else "looks"
    sentence = (
        f"{named} {verb} low-pass filtered{about}; a frame's noise before the filter cannot be "
        "told. Export unfiltered."
    )
    word, value = "usable" if cutoffs else "good", known[len(known) // 2] if known else math.nan
    name = next(iter(cutoffs), "")
    return Check("", name, "low-pass filter of the export", value, math.nan, "Hz", word, sentence)
