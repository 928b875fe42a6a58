"""Errors that recordings share, as a file of a pose has them, and what is none."""

import numpy as np
import pytest

from mocap_metrology.lighthouse.assess.pose_file import _check_covariance, _check_shared

SOUND = {"sd": [1e-3, 2e-3], "effect": [[0.1] * 6, [0.2] * 6]}


def shared(**changes: object) -> dict[str, object]:
    return {"digest": "a", "stations": SOUND, "board": {**SOUND, **changes}}


def test_sound_ones() -> None:
    _check_shared(None)
    _check_shared(shared())
    _check_shared(shared(sd=[], effect=[]))
    _check_covariance(None)
    _check_covariance(np.eye(6).tolist())


@pytest.mark.parametrize(
    "changes",
    [
        *({"sd": [1e-3, sd]} for sd in (0.0, -1e-9, float("nan"), float("inf"))),
        *({"effect": effect} for effect in ([[0.1] * 6], [[0.1] * 6, [float("nan")] * 6])),
        {"sd": [[1e-3, 2e-3]]},
        {"sd": 1e-3, "effect": [0.1] * 6},
    ],
)
def test_what_is_no_list_of_errors(changes: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="board is no list of errors and their effects"):
        _check_shared(shared(**changes))
    swapped = {"digest": "a", "stations": {**SOUND, **changes}, "board": SOUND}
    with pytest.raises(ValueError, match="stations is no list of errors"):
        _check_shared(swapped)


def test_what_is_no_covariance() -> None:
    lopsided = np.eye(6)
    lopsided[0, 1] = 1e-3
    for wrong in (lopsided, np.eye(5), np.full((6, 6), np.nan)):
        with pytest.raises(ValueError, match="no symmetric matrix of 6 x 6 finite numbers"):
            _check_covariance(wrong.tolist())
