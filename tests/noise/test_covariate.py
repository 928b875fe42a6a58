"""What was recorded beside a recording: times and values that cannot be used."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.covariate import Covariate, together

RATE = 100.0
SERIES = np.random.default_rng(1).normal(0, 0.01, 12_000)


@pytest.mark.parametrize("start", [1000.0, -500.0, 120.0])
def test_times_outside_the_recording_are_refused(start: float) -> None:
    covariate = Covariate("temperature_degC", start + np.arange(100.0), np.arange(100.0))
    with pytest.raises(
        Refusal, match=r"the recording of 0 to 120 s; expected times from its first"
    ):
        together(SERIES, RATE, covariate, 0.01)


def test_what_never_changes_is_refused() -> None:
    covariate = Covariate("temperature_degC", np.arange(121.0), np.full(121, 20.5))
    with pytest.raises(Refusal, match=r"temperature_degC stays at 20\.5"):
        together(SERIES, RATE, covariate, 0.01)
