"""How far a calibration can be trusted: named checks, and one word for all of them.

A low residual alone proves nothing, so beside the checks of the fit stand those of what it cannot
show.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.lighthouse.assess import fit_checks, outside_checks
from mocap_metrology.lighthouse.assess.fit_checks import EXPECTED_URAD, WORDS, Check
from mocap_metrology.lighthouse.calibrate.variants import Weighed
from mocap_metrology.lighthouse.records import PoseEstimate, Station


@dataclass(frozen=True)
class Verdict:
    """One of `WORDS`, and the checks behind it; why_none: where there are none, the reason that
    was given, if any."""

    word: str
    checks: tuple[Check, ...] = ()
    why_none: str = ""


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
        return Verdict("failed", why_none=why_none)
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
    return Verdict(word, checks)
