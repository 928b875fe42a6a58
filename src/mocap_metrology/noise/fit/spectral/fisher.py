"""Cramer-Rao bounds of noise coefficients from a recording of a given length."""

from __future__ import annotations

import math

import numpy as np

from mocap_metrology.noise.fit.spectral.lines import line_errors
from mocap_metrology.noise.fit.spectral.periodogram import Periodogram, bins_of
from mocap_metrology.noise.fit.spectral.whittle import Likelihood, Spectrum
from mocap_metrology.noise.model.components import Form, GaussMarkov, NoiseModel, PowerLaw


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

    information: by h, ln q_c^2, ln T_c (see `whittle.Fit`); the errors are of h, q_c and T_c.
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
