"""Standard errors, intervals and upper limits of a fit of `separable`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from mocap_metrology.noise.fit.allan.separable import Fit, projected
from mocap_metrology.noise.fit.estimates import ONE_SIDED_95, Z_68, Z_95, Coefficient, Components
from mocap_metrology.noise.model.components import Component, GaussMarkov, PowerLaw, Sinusoid

LIMIT_STEPS = 8


@dataclass(frozen=True)
class Found:
    """A fit and what limits need: alphas of its power laws; power: {alpha: (k,)} whitened unit
    curves of all; log_T (g,) with table (g, k), log_f (f,) with tones (k, f): what was scanned;
    again: the matrix that turns what was whitened with the fit into what would be whitened with
    the fit and one more component, or None where that hardly differs; ceiling: amplitude at which
    a component (given with amplitude 1) alone would contradict the data at some tau, at 99 %."""

    alphas: tuple[int, ...]
    fit: Fit
    power: dict[int, np.ndarray]
    log_T: np.ndarray
    table: np.ndarray
    log_f: np.ndarray
    tones: np.ndarray
    again: Callable[[Component], np.ndarray | None]
    ceiling: Callable[[Component], float]


def coefficients(found: Found, wanted: Components) -> tuple[tuple[Coefficient, ...], str]:
    """One for each of `wanted`, Gauss-Markov terms by rising T_c and those not detected last; and
    a note. Standard errors are those with the amplitudes that ended at 0 known to be 0. Intervals
    are symmetric in the logarithm: value exp(+-z std_error / value). For the slow components, whose
    error follows their size, those held in simulations where value +- z std_error did not. An upper
    end grows only linearly where the standard error exceeds the value."""
    fit, status = found.fit, "ok" if found.fit.converged else "not_converged"
    amplitude_error, shape_error, jacobian = _errors(found)
    first, size = len(found.alphas), fit.log_T.size
    h = {a: (fit.amplitudes[i], amplitude_error[i]) for i, a in enumerate(found.alphas)}
    lines, notes = [], []
    for alpha in sorted(wanted.alphas):
        if alpha in h and h[alpha][0] > 0:
            lines.append(_detected(f"h_{alpha}", *h[alpha], status))
        else:
            upper = _limit(found, jacobian, found.power[alpha], partial(PowerLaw, alpha))
            lines.append(_missing(f"h_{alpha}", upper))
    pairs = list(zip(fit.shaped, amplitude_error[first:], fit.shapes, shape_error, strict=True))
    for k in range(max(size, wanted.gauss_markov)):
        names = f"q_c{k + 1}", f"T_c{k + 1}"
        if k < size:
            lines += _pair(*names, *pairs[k], status)
        else:
            at = _likeliest(found.table.T, fit.residual, jacobian)
            T_c = float(np.exp(found.log_T[at]))
            top = _limit(found, jacobian, found.table[at], partial(_term, T_c))
            lines += [_missing(names[0], np.sqrt(top)), _missing(names[1], np.nan)]
            notes.append(f"limit of {names[0]} is for T_c = {T_c:.3g} s")
    if wanted.sinusoid and fit.log_f is not None and fit.shaped[-1] > 0:
        lines += _pair("A_s", "f_0", *pairs[-1], status)
    elif wanted.sinusoid:
        at = _likeliest(found.tones, fit.residual, jacobian)
        f_0 = float(np.exp(found.log_f[at]))
        top = _limit(found, jacobian, found.tones[:, at], lambda p: Sinusoid(p**0.5, f_0))
        lines += [_missing("A_s", np.sqrt(top)), _missing("f_0", np.nan)]
        notes.append(f"limit of A_s is for f_0 = {f_0:.3g} Hz")
    return tuple(lines), "; ".join(notes)


def _errors(found: Found) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Standard errors of amplitudes and of logarithms of shapes, NaN for what is not free (an
    amplitude of 0, a T_c on its bound), and the Jacobian (k, p) of what is."""
    fit = found.fit
    used, moves = fit.amplitudes > 0, fit.shaped > 0
    moves[: fit.log_T.size] &= (fit.log_T > found.log_T[0]) & (fit.log_T < found.log_T[-1])
    jacobian = np.hstack([fit.curves[:, used], (fit.slopes * fit.shaped)[:, moves]])
    errors = _standard_errors(jacobian)
    amplitude_error, shape_error = np.full(used.size, np.nan), np.full(moves.size, np.nan)
    amplitude_error[used] = errors[: used.sum()]
    shape_error[moves] = errors[used.sum() :]
    return amplitude_error, shape_error, jacobian


def _standard_errors(jacobian: np.ndarray) -> np.ndarray:
    """Roots of the diagonal of (J^T J)^-1; inf where the data do not determine them."""
    if not jacobian.shape[1]:
        return np.empty(0)
    norm = np.linalg.norm(jacobian, axis=0)
    _, values, right = np.linalg.svd(jacobian / norm, full_matrices=False)
    with np.errstate(divide="ignore", over="ignore"):
        return np.sqrt(np.sum((right / values[:, None]) ** 2, axis=0)) / norm


def _likeliest(columns: np.ndarray, residual: np.ndarray, jacobian: np.ndarray) -> int:
    """Where among the columns (k, g) one more component is most significant."""
    new = projected(columns, jacobian)
    with np.errstate(divide="ignore", invalid="ignore"):
        significance = residual @ new / np.sqrt(np.einsum("ij,ij->j", new, new))
    return int(np.argmax(np.nan_to_num(significance)))


def _limit(
    found: Found,
    jacobian: np.ndarray,
    column: np.ndarray,
    component: Callable[[float], Component],
) -> float:
    """One-sided 95 % limit of the amplitude of a component that is not in the fit, all that is
    fitted free: the h with h = max(0, estimate) + 1.645 standard errors, both with the covariance
    there would be if h were there (a slow component scatters by its own size). Where no h is large
    enough, as the fit has another slow component, that at which it alone would be too much."""
    residual = found.fit.residual
    h = _top(column, residual, jacobian)
    for _ in range(LIMIT_STEPS):
        if not np.isfinite(h):
            return found.ceiling(component(1.0))
        turned = found.again(component(h))
        if turned is None:
            return h
        higher = _top(turned @ column, turned @ residual, turned @ jacobian)
        if abs(higher - h) < 0.03 * h:
            return higher
        last, h = h, higher
    return h if h < 1.05 * last else found.ceiling(component(1.0))


def _top(column: np.ndarray, residual: np.ndarray, jacobian: np.ndarray) -> float:
    new = projected(column[:, None], jacobian)[:, 0]
    power = float(new @ new)
    if not power > 0:
        return np.inf
    return float(max(float(residual @ new) / power, 0.0) + ONE_SIDED_95 / power**0.5)


def _pair(
    amplitude: str,
    shape: str,
    square: float,
    square_error: float,
    log_shape: float,
    log_error: float,
    status: str,
) -> list[Coefficient]:
    """q_c and T_c, or A_s and f_0: the amplitude is the root of what was fitted. A shape without
    error is an end of its range."""
    root, value = float(np.sqrt(square)), float(np.exp(log_shape))
    return [
        _detected(amplitude, root, square_error / (2 * root), status),
        _detected(shape, value, value * log_error, status if log_error >= 0 else "at_bound"),
    ]


def _term(T_c: float, power: float) -> GaussMarkov:
    return GaussMarkov(power**0.5, T_c)


def _detected(name: str, value: float, error: float, status: str) -> Coefficient:
    value, error = float(value), float(error)
    ends: dict[str, float] = {}
    for label, z in (("68", Z_68), ("95", Z_95)):
        relative = error / value
        low = value * np.exp(-min(z * relative, 700.0))
        # Beyond a standard error as large as the value, straight on instead of exponentially
        up = np.exp(z * relative) if relative < 1 else 1 + relative * (np.exp(z) - 1)
        high = value * up
        ends |= {f"lower_{label}": float(low), f"upper_{label}": float(high)}
    return Coefficient(
        name,
        value,
        error,
        math.nan,
        ends["lower_68"],
        ends["upper_68"],
        ends["lower_95"],
        ends["upper_95"],
        status=status,
    )


def _missing(name: str, upper: float) -> Coefficient:
    return Coefficient(name, np.nan, upper_95=float(upper), detected=False, status="not_detected")
