"""What the functions of noise accept, and refuse one step beyond."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.allan.confidence import noise_exponents
from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.changes.compare import adev_trend, coherence
from mocap_metrology.noise.changes.covariate import Covariate, together
from mocap_metrology.noise.fit.allan.relative import Annealing, misfit
from mocap_metrology.noise.fit.estimates import Components
from mocap_metrology.noise.fit.spectral.likelihood import check_series
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid
from mocap_metrology.noise.motion.orientation import of_cluster
from mocap_metrology.noise.twins.simulate import frames_of

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
    return together(series, 10.0, Covariate("degC", np.arange(n + 1.0), WHITE[: n + 1]), 0.05)


def cluster(width: float) -> object:
    """Of three markers on a line of 1000 but for `width`: spreads 707 and 0.816 times the width."""
    points = np.array([[-500.0, 0, 0], [0, width, 0], [500, 0, 0]])
    return of_cluster(points[:, :, None] + np.zeros(100))


DAYS, EDF = [0, 20, 61], [50, 60, 40]
# What is accepted, and what is just beyond
LIMITS: dict[str, tuple[Callable[[], object], Callable[[], object]]] = {
    "power law": (lambda: PowerLaw(0, 0.0), lambda: PowerLaw(0, -1e-300)),
    "power law, upper": (lambda: PowerLaw(0, 1e308), lambda: PowerLaw(0, math.inf)),
    "correlated term": (lambda: GaussMarkov(0.0, 1.0), lambda: GaussMarkov(-1e-300, 1.0)),
    "correlated term, upper": (lambda: GaussMarkov(1e308, 1), lambda: GaussMarkov(math.inf, 1)),
    "correlation time": (lambda: GaussMarkov(1, 1e-300), lambda: GaussMarkov(1, 0.0)),
    "correlation time, upper": (lambda: GaussMarkov(1, 1e308), lambda: GaussMarkov(1, math.inf)),
    "amplitude": (lambda: Sinusoid(0.0, 1.0), lambda: Sinusoid(-1e-300, 1.0)),
    "amplitude, upper": (lambda: Sinusoid(1e308, 1.0), lambda: Sinusoid(math.inf, 1.0)),
    "frequency": (lambda: Sinusoid(1.0, 1e-300), lambda: Sinusoid(1.0, 0.0)),
    "frequency, upper": (lambda: Sinusoid(1.0, 1e308), lambda: Sinusoid(1.0, math.inf)),
    "width of a line": (lambda: Sinusoid(1.0, 1.0, 0.0), lambda: Sinusoid(1.0, 1.0, -1e-300)),
    "width, upper": (lambda: Sinusoid(1.0, 1.0, 1e308), lambda: Sinusoid(1.0, 1.0, math.inf)),
    "lines of a model": (
        lambda: NoiseModel((Sinusoid(1.0, 1.0),)),
        lambda: NoiseModel((Sinusoid(1.0, 1.0), Sinusoid(1.0, 2.0))),
    ),
    "averaging factor": (
        lambda: allan_variance(WHITE[:9], np.array([1])),
        lambda: allan_variance(WHITE[:9], np.array([0])),
    ),
    "Gauss-Markov terms": (
        lambda: Components(gauss_markov=0),
        lambda: Components(gauss_markov=-1),
    ),
    "variances for coefficients": (
        lambda: fitted(Components((-2, 0, 2), 1), longest_share=0.5),
        lambda: fitted(Components((-2, -1, 0, 2), 1), longest_share=0.5),
    ),
    "first averaging factor of a fit": (
        lambda: fitted(Components((0,), 0), np.array([1, 2])),
        lambda: fitted(Components((0,), 0), np.array([0.5, 2])),
    ),
    "frame rate of a fit": (
        lambda: fitted(Components((0,), 0), rate=1e-9),
        lambda: fitted(Components((0,), 0), rate=0.0),
    ),
    "duration over the longest tau": (
        lambda: fitted(Components((0,), 0), duration=16.001),
        lambda: fitted(Components((0,), 0), duration=16.0),
    ),
    "frames of a duration": (
        lambda: fitted(Components((0,), 0), duration=0.9999e8),
        lambda: fitted(Components((0,), 0), duration=1e8),
    ),
    "range of T_c": (
        lambda: fitted(Components((0,), 1), duration=48, shortest_frames=4, longest_share=0.084),
        lambda: fitted(Components((0,), 1), duration=48, shortest_frames=4, longest_share=1 / 12),
    ),
    "range of f_0": (
        lambda: fitted(Components((0,), 0, True), lowest_hz=0.49999),
        lambda: fitted(Components((0,), 0, True), lowest_hz=0.5),
    ),
    "samples": (lambda: check_series(WHITE[:1000]), lambda: check_series(WHITE[:999])),
    "missing samples": (
        lambda: check_series(with_missing(3000, 1500)),
        lambda: check_series(with_missing(3000, 1501)),
    ),
    "span over steps": (
        lambda: check_series(np.arange(1000.0), 2 * 999.0),
        lambda: check_series(np.arange(1000.0), 2 * 999.001),
    ),
    "recordings of a trend": (
        lambda: adev_trend(DAYS, [1, 2, 3], EDF, 0.9),
        lambda: adev_trend(DAYS[:2], [1, 2], EDF[:2], 0.9),
    ),
    "days of a trend": (
        lambda: adev_trend([0, 0, 1], [1, 2, 3], EDF, 0.9),
        lambda: adev_trend([0, 0, 0], [1, 2, 3], EDF, 0.9),
    ),
    "samples in common": (
        lambda: coherence(WHITE[:36], WHITE[50:86], 1.0),
        lambda: coherence(WHITE[:35], WHITE[50:85], 1.0),
    ),
    "blocks in common": (lambda: beside(36), lambda: beside(35)),
    "a quarter missing": (lambda: beside(100, 25), lambda: beside(100, 26)),
    "width of a cluster": (lambda: cluster(17.4), lambda: cluster(17.2)),
    "frames of a twin": (lambda: frames_of("a", 16.0, 1.0), lambda: frames_of("a", 15.0, 1.0)),
}


@pytest.mark.parametrize("name", LIMITS)
def test_accepts_up_to_the_limit_and_refuses_beyond(name: str) -> None:
    accepted, refused = LIMITS[name]
    accepted()
    with pytest.raises((Refusal, ValueError)):
        refused()


@pytest.mark.parametrize("gaps", [False, True])
def test_the_exponents_of_noise_do_not_depend_on_where_a_marker_is(gaps: bool) -> None:
    """Of 1 nm at 10 km, where sums of the positions themselves lose the noise in rounding."""
    walk = WHITE + 0.05 * np.cumsum(np.random.default_rng(2).standard_normal(WHITE.size))
    m = np.unique(np.geomspace(1, 120, 20).astype(int))
    for x in (WHITE, walk):
        own = np.where(np.arange(x.size) % 9 == 4, np.nan, x) if gaps else x
        assert noise_exponents(1e7 + 1e-6 * own, m).tolist() == noise_exponents(own, m).tolist()
