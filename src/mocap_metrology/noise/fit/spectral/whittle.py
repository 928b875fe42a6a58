"""Whittle likelihood of a binned periodogram, maximised by Fisher scoring; Cramer-Rao bounds of
noise coefficients from a recording of a given length.

In a bin of nu coefficients with mean periodogram P and expectation S the log likelihood is
-nu/2 (ln S + P/S): nu P/S is chi-squared with nu degrees of freedom [Whittle 1953]. S is linear in
h_alpha and q_c^2 and not in T_c. Scoring solves the weighted least squares of (P - S)/S with the
variances 2/nu of the current S; damping and a check of the likelihood make every step an ascent.

The compiled inner loop has the parameters p in one vector: h of every power law, then ln q_c^2 and
ln T_c of every Gauss-Markov component in turn. With weights nu/2 the gradient and the Fisher
information of ln L are sum nu/2 (P/S - 1) dlnS/dp and sum nu/2 dlnS/dp_i dlnS/dp_j.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.linear import non_negative
from mocap_metrology.common.types import Floats
from mocap_metrology.noise.fit.spectral.line import line_errors
from mocap_metrology.noise.fit.spectral.periodogram import (
    Periodogram,
    Where,
    bins_of,
    gauss_markov_unit,
    power_law_unit,
    unit_into,
)
from mocap_metrology.noise.model.components import ALPHAS, Form, GaussMarkov, NoiseModel, PowerLaw

LARGEST_STEP = 2.3  # of a logarithm at once
LEAST_DAMPING, MOST_DAMPING = 1e-9, 1e8
DAMPING_FACTOR = 8.0  # the damping falls by it after a step that climbs, else it rises
GONE_INFORMATION = (
    1e-6  # information on a logarithm below which its component has vanished for good
)
LEAST_DENSITY = 1e-140  # its square must be a number too
STEP_LN_T = 1e-3  # derivative of a Gauss-Markov spectrum by ln T_c: from this far to either side
MAX_STEPS = 200
GRID = 40  # values of T_c of a mixture
TOLERANCE = 1e-5  # of twice the log likelihood, whose sampling scatter is of order 1


# Power laws (L, B), a density (B,) that is not fitted, and what Gauss-Markov spectra need
Model = tuple[Floats, Floats, Where]


@njit
def spectra(p: Floats, model: Model, columns: Floats) -> Floats:
    """Density (B,); its derivatives go to `columns`, (p, B), or (0, B) if not wanted."""
    laws, fixed, where = model
    n_h, wanted = laws.shape[0], columns.shape[0] == p.size
    density = fixed.copy()
    for i in range(n_h):
        density += p[i] * laws[i]
    if wanted:
        columns[:n_h] = laws
    unit, up, down = np.empty(fixed.size), np.empty(fixed.size), np.empty(fixed.size)
    for i in range(n_h, p.size, 2):
        q2 = math.exp(p[i])
        unit_into(math.exp(p[i + 1]), where, unit)
        density += q2 * unit
        if wanted:
            unit_into(math.exp(p[i + 1] + STEP_LN_T), where, up)
            unit_into(math.exp(p[i + 1] - STEP_LN_T), where, down)
            columns[i] = q2 * unit
            columns[i + 1] = q2 * (up - down) / (2 * STEP_LN_T)
    return density


@njit
def deviance_of(psd: Floats, weight: Floats, density: Floats) -> float:
    """sum nu (P/S - 1 - ln P/S); infinite where the density has vanished."""
    total = 0.0
    for b in range(psd.size):
        if not density[b] > LEAST_DENSITY:
            return np.inf
        ratio = psd[b] / density[b]
        total += weight[b] * (ratio - 1.0 - math.log(ratio))
    return total


@njit
def normal_equations(
    psd: Floats, weight: Floats, density: Floats, columns: Floats
) -> tuple[Floats, Floats]:
    """Gradient (p,) and Fisher information (p, p) of ln L."""
    scaled = columns * (0.5 * weight / density**2)
    return np.dot(scaled, psd - density), np.dot(scaled, columns.T)


@njit
def _trial(
    p: Floats, n_h: int, equations: tuple[Floats, Floats], damping: float, ends: tuple[float, float]
) -> Floats:
    """p after one scoring step of the parameters that are free to move.

    h stays >= 0 and ln T_c within its ends; what lies at an end and is pulled out of it is
    held. The information is scaled to unit diagonal, so the damping has no unit.
    """
    gradient, information = equations
    low, high = ends
    ln_T, pull = p[n_h + 1 :: 2], gradient[n_h + 1 :: 2]
    held = np.diag(information) < GONE_INFORMATION
    held[:n_h] = (p[:n_h] <= 0.0) & (gradient[:n_h] <= 0.0)
    held[n_h + 1 :: 2] |= (ln_T <= low) & (pull < 0.0) | (ln_T >= high) & (pull > 0.0)
    free = np.flatnonzero(~held)
    scale = 1 / np.sqrt(np.diag(information)[free])
    matrix = information[free][:, free] * np.outer(scale, scale) + damping * np.eye(free.size)
    step = np.zeros(p.size)
    step[free] = scale * np.linalg.solve(matrix, scale * gradient[free])
    step[n_h:] = np.minimum(np.maximum(step[n_h:], -LARGEST_STEP), LARGEST_STEP)
    out = p + step
    out[:n_h] = np.maximum(out[:n_h], 0.0)
    out[n_h + 1 :: 2] = np.minimum(np.maximum(out[n_h + 1 :: 2], low), high)
    return out


@njit
def ascend(
    p: Floats,
    model: Model,
    psd: Floats,
    weight: Floats,
    bounds: tuple[float, float],
    tolerance: float,
) -> tuple[Floats, float, bool]:
    """Climb from p: the parameters, the deviance, and whether the last steps gained too little."""
    n_h, n_bins = model[0].shape
    columns, none = np.empty((p.size, n_bins)), np.empty((0, n_bins))
    density = spectra(p, model, columns)
    deviance = deviance_of(psd, weight, density)
    damping, idle = 1e-3, 0
    for _ in range(MAX_STEPS):
        equations = normal_equations(psd, weight, density, columns)
        while True:
            trial = _trial(p, n_h, equations, damping, bounds)
            then = deviance_of(psd, weight, spectra(trial, model, none))
            if then <= deviance or damping > MOST_DAMPING:
                break
            damping *= DAMPING_FACTOR
        if not then <= deviance:
            return p, deviance, True  # no direction leads up any further
        idle = idle + 1 if deviance - then < tolerance else 0
        p, deviance = trial, then
        if idle == 2:
            return p, deviance, True
        density = spectra(p, model, columns)
        damping = max(damping / DAMPING_FACTOR, LEAST_DAMPING)
    return p, deviance, False


@dataclass(frozen=True)
class Spectrum:
    """Power laws (alpha -> h) and Gauss-Markov components: q_c^2 and T_c (s), each (K,)."""

    h: dict[int, float]
    q2: np.ndarray
    T_c: np.ndarray

    @property
    def size(self) -> int:
        """Number of free parameters."""
        return len(self.h) + 2 * len(self.T_c)


@dataclass(frozen=True)
class Fit:
    """A maximum of the likelihood. deviance: sum nu (P/S - 1 - ln P/S), the part of
    -2 ln L that depends on the model; converged: the last step gained less than the tolerance;
    information: Fisher information of (h by alpha, ln q_c^2 and ln T_c in turn)."""

    spectrum: Spectrum
    deviance: float
    converged: bool
    information: np.ndarray


class Likelihood:
    """Whittle likelihood of one periodogram; T_c is confined to `bounds` (s), by default those of
    its bins."""

    def __init__(self, data: Periodogram, bounds: tuple[float, float] | None = None) -> None:
        self.bins, self.weight, self.bounds = data.bins, data.weight, bounds or data.bins.T_c_range
        # A stretch without any power in a bin would have no logarithm
        self.psd = np.maximum(data.psd, np.finfo(float).tiny)
        self.laws = {a: power_law_unit(self.bins, a) for a in ALPHAS}

    def _model(self, spectrum: Spectrum, fixed: np.ndarray | None = None) -> Model:
        laws = np.array([self.laws[a] for a in spectrum.h]).reshape(-1, self.psd.size)
        return laws, np.zeros(self.psd.size) if fixed is None else fixed, self.bins.where

    def density(self, spectrum: Spectrum) -> np.ndarray:
        """(B,) expected periodogram."""
        none = np.empty((0, self.psd.size))
        return spectra(_packed(spectrum), self._model(spectrum), none)

    def jacobian(self, spectrum: Spectrum) -> tuple[np.ndarray, np.ndarray]:
        """(B,) density and (B, p) its derivatives by h, ln q_c^2, ln T_c."""
        columns = np.empty((spectrum.size, self.psd.size))
        return spectra(_packed(spectrum), self._model(spectrum), columns), columns.T

    def information(self, spectrum: Spectrum) -> np.ndarray:
        """(p, p) Fisher information sum nu/2 dlnS/dp_i dlnS/dp_j."""
        density, columns = self.jacobian(spectrum)
        return normal_equations(self.psd, self.weight, density, columns.T)[1]

    def misfit(self, fit: Fit) -> float:
        """How many standard deviations the deviance lies above what chance explains.

        nu P/S is chi-squared: nu (P/S - 1 - ln P/S) has the mean nu (ln nu/2 - digamma(nu/2)) and
        the variance nu^2 trigamma(nu/2) - 2 nu; each parameter fitted takes one off the sum.
        """
        from scipy.special import digamma, polygamma

        nu = self.weight
        mean = np.sum(nu * (np.log(nu / 2) - digamma(nu / 2))) - fit.spectrum.size
        variance = np.sum(nu**2 * polygamma(1, nu / 2) - 2 * nu)
        return float((fit.deviance - mean) / math.sqrt(variance))

    def fit(
        self, start: Spectrum, fixed: np.ndarray | None = None, tolerance: float = TOLERANCE
    ) -> Fit:
        """Ascend from `start` by damped Fisher scoring; h >= 0, T_c within its bounds.

        fixed: (B,) density that is there beside the spectrum and not fitted; tolerance: gain in
        twice the log likelihood below which a step counts as the last.
        """
        model, (low, high) = self._model(start, fixed), map(math.log, self.bounds)
        p, deviance, converged = ascend(
            _packed(start), model, self.psd, self.weight, (low, high), tolerance
        )
        n_h = len(start.h)
        q2, T_c = np.exp(p[n_h::2]), np.exp(p[n_h + 1 :: 2])
        order = np.argsort(T_c)
        now = Spectrum(dict(zip(start.h, p[:n_h].tolist(), strict=True)), q2[order], T_c[order])
        return Fit(now, deviance, converged, self.information(now))


def _packed(spectrum: Spectrum) -> np.ndarray:
    """The parameter vector of the compiled loop."""
    logs = np.log(np.stack([np.maximum(spectrum.q2, 1e-300), spectrum.T_c], axis=1))
    return np.array([*map(float, spectrum.h.values()), *logs.ravel()])


def dictionary(likelihood: Likelihood, alphas: Sequence[int]) -> Spectrum:
    """Non-negative mixture of power laws and Gauss-Markov spectra on a grid of T_c.

    Linear in all its coefficients, so its optimum needs no start: least squares of (P - S)/S by
    non-negative least squares, reweighted. Neighbouring T_c that are both used are one component.
    """
    grid = np.geomspace(*likelihood.bounds, GRID)
    units = [gauss_markov_unit(likelihood.bins, T) for T in grid]
    columns = np.stack([*(likelihood.laws[a] for a in alphas), *units], axis=1)
    root = np.sqrt(likelihood.weight / 2)
    nine = np.ones(9)  # a running mean, as single coefficients scatter
    density = np.convolve(likelihood.psd * likelihood.weight, nine)[4:-4]
    density /= np.convolve(likelihood.weight, nine)[4:-4]
    for _ in range(5):
        scale = root / density
        x = non_negative(columns * scale[:, None], likelihood.psd * scale)
        density = np.maximum(columns @ x, 1e-6 * density)
    h = {a: max(float(v), 0.0) for a, v in zip(alphas, x, strict=False)}
    q2 = x[len(h) :]
    used = np.flatnonzero(q2 > 0)
    groups = np.split(used, np.flatnonzero(np.diff(used) > 1) + 1) if used.size else []
    total = [q2[g].sum() for g in groups]
    T_c = [math.exp(np.average(np.log(grid[g]), weights=q2[g])) for g in groups]
    return Spectrum(h, np.array(total), np.array(T_c))


def spectrum_of(model: NoiseModel) -> Spectrum:
    """The broadband components of a model as the likelihood names them."""
    laws = {c.alpha: c.h for c in model.broadband if isinstance(c, PowerLaw)}
    terms = [c for c in model.broadband if isinstance(c, GaussMarkov)]
    return Spectrum(laws, np.array([c.q_c**2 for c in terms]), np.array([c.T_c for c in terms]))


def model_of(spectrum: Spectrum, form: Form = "sampled") -> NoiseModel:
    """The inverse of `spectrum_of`, in frames of that form."""
    laws = [PowerLaw(a, float(h)) for a, h in spectrum.h.items()]
    pairs = zip(spectrum.q2, spectrum.T_c, strict=True)
    terms = [GaussMarkov(math.sqrt(q2), float(T)) for q2, T in pairs]
    return NoiseModel((*laws, *terms), form)


def standard_errors(information: np.ndarray, spectrum: Spectrum) -> dict[str, float]:
    """Square roots of the diagonal of the inverse information, by parameter name.

    information: by h, ln q_c^2, ln T_c (see `Fit`); the errors are of h, q_c and T_c.
    A parameter the likelihood does not depend on (T_c of an empty component) has an infinite one,
    and no say in the others'.
    """
    diagonal = np.diag(information)
    known = diagonal > 1e-290
    error = np.full(diagonal.size, math.inf)
    if known.any():
        scale = 1 / np.sqrt(diagonal[known])
        correlation = scale[:, None] * information[np.ix_(known, known)] * scale
        # Two components of one shape: no digits are left, and either can be anything
        value, vector = np.linalg.eigh(correlation)
        value = np.maximum(value, 1e-15)
        error[known] = scale * np.sqrt((vector**2 / value).sum(axis=1))
    size = np.stack([np.sqrt(spectrum.q2) / 2, spectrum.T_c], axis=1)
    error[len(spectrum.h) :] *= size.ravel()
    terms = [f"{p}{k + 1}" for k in range(len(spectrum.T_c)) for p in ("q_c", "T_c")]
    names = [f"h_{a}" for a in spectrum.h] + terms
    return dict(zip(names, error.tolist(), strict=True))


def crlb(model: NoiseModel, n: int, frame_rate_hz: float) -> dict[str, float]:
    """Least standard error of every coefficient from n samples, all of them unknown.

    Inverse of the Fisher information of the spectrum of frames of the model's form [Whittle 1953],
    I_ij = T Int_0^fN dlnS/dp_i dlnS/dp_j df, one-sided S, evaluated on the bins of the DCT;
    A_s and f_0 of a line as `lines.line_errors`. Units as the coefficients; infinite for what the
    spectrum does not depend on. Gauss-Markov terms are numbered in the order of the model.
    """
    tau0 = 1 / frame_rate_hz
    spectrum = spectrum_of(model)
    bins = bins_of(n, frame_rate_hz, form=model.form)
    weight = bins.n.astype(float)
    likelihood = Likelihood(Periodogram(bins, np.ones(weight.size), weight), (tau0 / 2, n * tau0))
    errors = standard_errors(likelihood.information(spectrum), spectrum)
    for line in model.lines:
        psd = float(model.psd(np.array([min(line.f_0, 0.5 / tau0)]), frame_rate_hz)[0])
        high = line.recorded(frame_rate_hz, model.form)
        errors["A_s"], errors["f_0"] = line_errors(high, psd, n * tau0)
        errors["A_s"] *= line.A_s / high if high > 0 else 1.0
    return errors


def warm_up() -> None:
    """Compile the kernels."""
    bins = bins_of(64, 1.0)
    likelihood = Likelihood(Periodogram(bins, np.ones(bins.n.size), bins.n.astype(float)))
    for T_c in (np.array([]), np.array([5.0])):
        likelihood.fit(Spectrum({0: 1.0}, np.full(T_c.size, 1e-3), T_c))
