"""Objects of one recording of two stations: their poses of the slave are estimates of one pose."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.assess.comparison import Comparison, compare_with_earlier
from mocap_metrology.lighthouse.assess.fit_checks import WORDS, Case, Check
from mocap_metrology.lighthouse.assess.pose_file import PoseFile, check_row
from mocap_metrology.lighthouse.assess.summary import Summary

APART_P = 0.01  # by chance, of all comparisons of an object together


def with_objects(found: Summary, others: Mapping[str, PoseFile]) -> Summary:
    """With a check against the poses from other objects of the same recording, by name.

    Of m comparisons the least probability by chance p counts as min(1, m p). Below `APART_P` one
    pose at least is farther off than stated, and it is unknown which: the word is one worse, but
    `failed` only where it was so before. Others that are `failed` state nothing. Without a
    comparison the summary is unchanged.
    """
    compared: list[tuple[Comparison, str]] = []
    for name, other in others.items():
        with suppress(Refusal):  # without a pose, or of other stations
            one = compare_with_earlier(found.document, other, one_board=False)
            if other["verdict"]["word"] != "failed" and np.isfinite(one.p_value):
                compared.append((one, name))
    if not compared:
        return found
    worst, name = min(compared, key=lambda pair: pair[0].p_value)
    p, word = min(1.0, len(compared) * worst.p_value), found.verdict.word
    case, level = Case.OBJECTS, "good"
    if p < APART_P:
        case, level = Case.OBJECTS_APART, WORDS[min(WORDS.index(word) + 1, 2)]
    mm, deg = worst.shift
    numbers = {"mm": mm, "deg": deg}
    check = Check(
        "objects agree", case, p, "", APART_P, level == "good", level, numbers, names=(name,)
    )
    word = max(word, level, key=WORDS.index)
    judged = replace(found.verdict, word=word, checks=(*found.verdict.checks, check))
    document: PoseFile = {
        **found.document,
        "verdict": found.document["verdict"] | {"word": word},
        "checks": [*found.document["checks"], check_row(check)],
    }
    return replace(found, document=document, verdict=judged)
