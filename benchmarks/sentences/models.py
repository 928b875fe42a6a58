"""Intervals of noise coefficients when the data also select the model.

Published: for each of the 154 series of Tables A1-A3, nine hours at 120 Hz, the binned periodogram
is drawn from its distribution (no lines). Gauss-Markov terms are paired with the true ones by T_c,
within a factor of three; terms whose Cramer-Rao bound exceeds their value are excluded. Kinds: 15
min at 100 Hz, whole series, the default chain. A coefficient that was not detected holds if its
95 % limit is above the truth. Width: of 95 % intervals over those of the Cramer-Rao bound, median,
where the correct model was selected.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator

import numpy as np
from scipy.optimize import linear_sum_assignment

from benchmarks.sentences import Row, percent
from mocap_metrology.noise.fit.spectral.detrend import without_part
from mocap_metrology.noise.fit.spectral.intervals import coefficients
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.fit.spectral.order import choose, penalty
from mocap_metrology.noise.fit.spectral.periodogram import Periodogram, bins_of
from mocap_metrology.noise.fit.spectral.rivals import judged
from mocap_metrology.noise.fit.spectral.whittle import Likelihood, crlb, spectrum_of
from mocap_metrology.noise.model.components import ALPHAS, NoiseModel
from mocap_metrology.noise.model.synthesis import Cross, draw_pair
from mocap_metrology.noise.twins.published import SERIES, published_keys, published_row

NINE_HOURS, RATE = 3_888_000, 120.0
PAIRED = math.log(3.0)
H0 = 5e-5  # white noise of 0.05 mm at 100 Hz
REACH, WIDTH = ">= 90 %", "<= 1.5"
KINDS = {
    "white": {},
    "white, 2 min": {},
    "random walk": {"h_-2": 2e-8},
    "weak random walk": {"h_-2": 2e-10},
    "flicker": {"h_-1": 2.5e-6},
    "weak flicker": {"h_-1": 1e-7},
    "Gauss-Markov 1 s": {"q_c1": 0.022, "T_c1": 1.0},
    "weak Gauss-Markov 1 s": {"q_c1": 0.0045, "T_c1": 1.0},
    "Gauss-Markov 1 s and 300 s": {"q_c1": 0.022, "T_c1": 1.0, "q_c2": 0.0013, "T_c2": 300.0},
    "random walk and Gauss-Markov 10 s": {"h_-2": 5e-9, "q_c1": 0.007, "T_c1": 10.0},
}


def rows(n: int) -> Iterator[Row]:
    """n recordings of each kind; n / 100 of each published series, one at least."""
    yield from _published(max(n // 100, 1))
    for kind in KINDS:
        yield from _kind(kind, n)


class Tally:
    """What held, how wide, by coefficient; `right`: how often the true model was chosen."""

    def __init__(self) -> None:
        self.held: dict[str, list[bool]] = defaultdict(list)
        self.width: dict[str, list[float]] = defaultdict(list)
        self.right: list[bool] = []

    def add(self, found: dict, truth: dict[str, float], bounds: dict[str, float]) -> None:
        """Coefficients by name of one recording."""
        detected = {k for k, c in found.items() if c.detected and k[0] in "hqT"}
        self.right.append({k for k in truth if k[0] in "hqT"} == detected)
        for name, true in truth.items():
            if name[0] == "h" and name in found:
                self._judge(name, found[name], true, bounds[name])
        sure = {
            k: true
            for k, true in truth.items()
            if all(bounds[of] < truth[of] for of in (k, k.replace("T_c", "q_c")))
        }
        for mine, theirs in paired({k: c.value for k, c in found.items() if c.detected}, sure):
            for kind in ("q_c", "T_c"):
                true = theirs.replace("T_c", kind)
                self._judge(kind, found[mine.replace("T_c", kind)], truth[true], bounds[true])

    def _judge(self, name: str, c, true: float, bound: float) -> None:
        low = c.lower_95 if c.detected else 0.0
        self.held[name].append(bool(low <= true <= c.upper_95))
        if c.detected and self.right[-1]:
            self.width[name].append((c.upper_95 - c.lower_95) / (3.92 * bound))

    def rows(self, case: str) -> Iterator[Row]:
        """Of one case."""
        for name in sorted(self.held):
            held = self.held[name]
            said = f"95 % intervals and limits of {name} hold"
            yield case, said, len(held), REACH, percent(held)
            if width := self.width.get(name):
                middle = f"{np.median(width):.2f}"
                yield case, f"width of {name} / bound", len(width), WIDTH, middle


def paired(values: dict[str, float], truth: dict[str, float]) -> list[tuple[str, str]]:
    """Names of the T_c of Gauss-Markov terms and of the true ones they stand for."""
    mine, theirs = ([k for k in own if k.startswith("T_c")] for own in (values, truth))
    if not (mine and theirs):
        return []
    apart = np.abs(np.log([[values[a] / truth[b] for b in theirs] for a in mine]))
    return [
        (mine[i], theirs[j])
        for i, j in zip(*linear_sum_assignment(np.minimum(apart, 10)), strict=True)
        if apart[i, j] <= PAIRED
    ]


def _published(n: int) -> Iterator[Row]:
    tally = Tally()
    for camera_type, cameras in published_keys():
        for series in SERIES:
            truth = NoiseModel(published_row(camera_type, cameras)[series].broadband)
            bounds = crlb(truth, NINE_HOURS, RATE)
            for run in range(n):
                seed = [run, cameras, *camera_type.encode(), *series.encode()]
                data = drawn(truth, NINE_HOURS, RATE, seed)
                found = {c.parameter: c for c in _of_periodogram(data)}
                tally.add(found, truth.coefficients(), bounds)
    yield from tally.rows("154 published series")


def drawn(truth: NoiseModel, n: int, frame_rate_hz: float, seed: int | list[int]) -> Periodogram:
    """The binned periodogram of n samples, drawn from its distribution."""
    bins = bins_of(n, frame_rate_hz)
    weight = bins.n.astype(float)
    flat = Likelihood(Periodogram(bins, np.ones(weight.size), weight), bins.T_c_range)
    ratio = np.random.default_rng(seed).chisquare(weight) / weight
    return Periodogram(bins, flat.density(spectrum_of(truth)) * ratio, weight)


def _of_periodogram(data: Periodogram):
    model = Likelihood(data, data.bins.T_c_range)
    fit = choose(model, ALPHAS, 4)
    cost = penalty("bic", float(data.psd.size))
    fit, near = judged([without_part(data, fit, cost)], ALPHAS, 4, cost)
    return coefficients(data, fit, None, None, 4, False, near, cost)


def _kind(kind: str, n: int) -> Iterator[Row]:
    frames = 12_000 if kind.endswith("2 min") else 90_000
    truth = NoiseModel.from_coefficients({"h_0": H0, **KINDS[kind]})
    bounds, tally = crlb(truth, frames, 100), Tally()
    for run in range((n + 1) // 2):
        rng = np.random.default_rng([run, *kind.encode()])
        for series in draw_pair(truth, truth, Cross(constant=0.0), frames, 100, rng):
            found = likelihood(series, 100).estimate.coefficients
            tally.add({c.parameter: c for c in found}, truth.coefficients(), bounds)
    yield from tally.rows(kind)
    yield kind, "true model chosen", len(tally.right), "", percent(tally.right)
