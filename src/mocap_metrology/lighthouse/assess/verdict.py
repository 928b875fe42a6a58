"""How far a calibration can be trusted: named checks, and one word for all of them.

A low residual alone proves nothing, so beside the checks of the fit stand those of what it cannot
show.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mocap_metrology.lighthouse.assess import fit_checks, outside_checks
from mocap_metrology.lighthouse.assess.fit_checks import EXPECTED_URAD, WORDS, Check
from mocap_metrology.lighthouse.calibrate.variants import Weighed
from mocap_metrology.lighthouse.records import PoseEstimate, Station


class Verdict(NamedTuple):
    """One of `WORDS`, one or two sentences, and the checks behind them."""

    word: str
    reason: str
    checks: tuple[Check, ...] = ()


def verdict(
    chosen: PoseEstimate | None,
    poses: Sequence[PoseEstimate],
    stations: Sequence[Station],
    *,
    n_common: int | None = None,
    span_m: float | None = None,
    duration_s: float | None = None,
    expected_urad: float = EXPECTED_URAD,
    board_rms_urad: float | None = None,
    errors: tuple[np.ndarray, np.ndarray] | None = None,
    variants: Sequence[Weighed] = (),
    why_none: str = "",
) -> Verdict:
    """Verdict on the pose `chosen` out of `poses`.

    stations: master first; n_common: moments with a board pose of both stations; span_m: largest
    distance between two places of the board's path, or about it; duration_s: of the recording;
    expected_urad: noise of one angle; board_rms_urad: angles about single board poses; errors: mm
    and deg against a reference, see `reference`; variants: of the rotor model, as the recording
    weighed them; why_none: the reason where nothing was chosen.
    """
    if chosen is None or not (np.isfinite(chosen.R).all() and np.isfinite(chosen.t_m).all()):
        return Verdict("failed", why_none or "No pose of the slave was found.")
    checks = (
        fit_checks.distance(chosen),
        fit_checks.residual(chosen, expected_urad),
        outside_checks.factory(chosen, stations),
        outside_checks.rotor_model(chosen, variants),
        fit_checks.mirrored(chosen),
        fit_checks.motion(chosen),
        fit_checks.common_measurements(chosen, n_common),
        fit_checks.board_poses(board_rms_urad, expected_urad),
        fit_checks.path(chosen, span_m),
        *outside_checks.agreements(chosen, poses),
        outside_checks.gravity(chosen, stations),
        fit_checks.weighted(chosen, expected_urad),
        fit_checks.halves(chosen),
        fit_checks.uncertainty(chosen),
        fit_checks.duration(duration_s),
        outside_checks.against_reference(errors),
    )
    word = max((c.level for c in checks), key=WORDS.index)
    return Verdict(word, _reason(word, checks), checks)


def _reason(word: str, checks: Sequence[Check]) -> str:
    """The sentences of the checks that made the word, then what else was found, in short."""
    models = [c.sentence for c in checks if c.name == "rotor model" and c.ok is False]
    if word == "good":
        passed = sum(c.ok is True for c in checks)
        said = [c.sentence for c in checks if c.ok and c.name in ("residual", "uncertainty")]
        return " ".join([f"All {passed} checks passed.", *said, *models])
    bad = [c for c in checks if c.level == word]
    rest = [*bad[2:], *(c for c in checks if c.level not in (word, "good"))]
    more = (c.sentence.split(", as by ")[0].rstrip(".") + "." for c in rest)
    return " ".join([*(c.sentence for c in bad[:2]), *more, *models])
