"""What the functions of noise accept, and refuse one step beyond."""

from collections.abc import Callable

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.changes.compare import adev_trend, coherence
from mocap_metrology.noise.changes.covariate import Covariate, coherence_row
from mocap_metrology.noise.diagnosis.dynamic import dynamic_allan
from mocap_metrology.noise.diagnosis.export import bands, low_pass
from mocap_metrology.noise.fit.allan.relative import Annealing, misfit
from mocap_metrology.noise.fit.estimates import Components
from mocap_metrology.noise.fit.spectral.likelihood import check_series
from mocap_metrology.noise.model.components import NoiseModel, Sinusoid

M = np.array([1, 2, 4, 8, 16])
WHITE = np.random.default_rng(1).standard_normal(4000)


def fitted(components: Components, m: np.ndarray = M, rate: float = 1.0, **search: float) -> object:
    duration = search.pop("duration", None)
    return misfit(m, 1 / m, rate, components, search=Annealing(**search), duration=duration)


def with_missing(n: int, n_missing: int) -> np.ndarray:
    series = WHITE[:n].copy()
    series[:n_missing] = np.nan
    return series


def beside(n: int, n_missing: int = 0) -> dict[str, object]:
    """A series of n s at 10 Hz of which the first seconds are missing, and a covariate of 1 Hz."""
    series = np.repeat(WHITE[:n], 10)
    series[: 10 * n_missing] = np.nan
    return coherence_row(series, 10.0, Covariate("degC", np.arange(n + 1.0), WHITE[: n + 1]), 0.05)


DAYS, EDF = [0, 20, 61], [50, 60, 40]
# What is accepted, and what is just beyond
LIMITS: dict[str, tuple[Callable[[], object], Callable[[], object]]] = {
    "lines of a model": (lambda: NoiseModel((Sinusoid(1.0, 1.0),)),
                         lambda: NoiseModel((Sinusoid(1.0, 1.0), Sinusoid(1.0, 2.0)))),
    "averaging factor": (lambda: allan_variance(WHITE[:9], np.array([1])),
                         lambda: allan_variance(WHITE[:9], np.array([0]))),
    "Gauss-Markov terms": (lambda: Components(gauss_markov=0), lambda: Components(gauss_markov=-1)),
    "variances for coefficients": (lambda: fitted(Components((-2, 0, 2), 1), longest_share=0.5),
                                   lambda: fitted(Components((-2, -1, 0, 2), 1),
                                                  longest_share=0.5)),
    "first averaging factor of a fit": (lambda: fitted(Components((0,), 0), np.array([1, 2])),
                                        lambda: fitted(Components((0,), 0), np.array([0.5, 2]))),
    "frame rate of a fit": (lambda: fitted(Components((0,), 0), rate=1e-9),
                            lambda: fitted(Components((0,), 0), rate=0.0)),
    "duration over the longest tau": (lambda: fitted(Components((0,), 0), duration=16.001),
                                      lambda: fitted(Components((0,), 0), duration=16.0)),
    "frames of a duration": (lambda: fitted(Components((0,), 0), duration=0.9999e8),
                             lambda: fitted(Components((0,), 0), duration=1e8)),
    "range of T_c": (lambda: fitted(Components((0,), 1), duration=48, shortest_frames=4,
                                    longest_share=0.084),
                     lambda: fitted(Components((0,), 1), duration=48, shortest_frames=4,
                                    longest_share=1 / 12)),
    "range of f_0": (lambda: fitted(Components((0,), 0, True), lowest_hz=0.49999),
                     lambda: fitted(Components((0,), 0, True), lowest_hz=0.5)),
    "missing samples": (lambda: check_series(with_missing(3000, 1500)),
                        lambda: check_series(with_missing(3000, 1501))),
    "span over steps": (lambda: check_series(np.arange(1000.0), 2 * 999.0),
                        lambda: check_series(np.arange(1000.0), 2 * 999.001)),
    "recordings of a trend": (lambda: adev_trend(DAYS, [1, 2, 3], EDF, 0.9),
                              lambda: adev_trend(DAYS[:2], [1, 2], EDF[:2], 0.9)),
    "days of a trend": (lambda: adev_trend([0, 0, 1], [1, 2, 3], EDF, 0.9),
                        lambda: adev_trend([0, 0, 0], [1, 2, 3], EDF, 0.9)),
    "samples in common": (lambda: coherence(WHITE[:36], WHITE[50:86], 1.0),
                          lambda: coherence(WHITE[:35], WHITE[50:85], 1.0)),
    "blocks in common": (lambda: beside(36), lambda: beside(35)),
}  # fmt: skip


@pytest.mark.parametrize("name", LIMITS)
def test_accepts_up_to_the_limit_and_refuses_beyond(name: str) -> None:
    accepted, refused = LIMITS[name]
    accepted()
    with pytest.raises((Refusal, ValueError)):
        refused()


def test_too_little_of_a_series_shows_no_spectrum_and_no_windows() -> None:
    gone, still = np.full(5000, np.nan), np.full(5000, 3.0)
    assert bands(gone, 100.0) is None and low_pass("x1", bands(still, 100.0), 100.0) is None
    for x in (gone, still, WHITE[:15]):
        assert dynamic_allan(x, 100.0) == []
