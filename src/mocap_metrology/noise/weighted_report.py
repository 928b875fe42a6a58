"""Standard errors, intervals and upper limits of a fit of `separable`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.noise.estimates import Z_68, Z_95, Coefficient, Components
from mocap_metrology.noise.separable import Fit, Problem, projected

ONE_SIDED_95 = 1.6448536269514722


@dataclass(frozen=True)
class Found:
    """A fit and what limits need: alphas and fit as fitted with `problem`; power: {alpha: (k,)}
    whitened unit curves of all power laws asked for; log_f (f,) and tones (k, f) as scanned."""

    alphas: tuple[int, ...]
    fit: Fit
    problem: Problem
    power: dict[int, np.ndarray]
    log_f: np.ndarray
    tones: np.ndarray


def coefficients(found: Found, wanted: Components) -> tuple[tuple[Coefficient, ...], str]:
    """One for each of `wanted`, Gauss-Markov terms by rising T_c and those not detected last; and
    a note. Intervals are symmetric in the logarithm where the standard error is below the value,
    else about the value and cut at 0: none is negative."""
    fit, first = found.fit, len(found.alphas)
    used = fit.amplitudes > 0
    own = fit.shaped
    low, high = found.problem.log_T[[0, -1]]
    inside = np.ones(own.size, bool)
    inside[: fit.log_T.size] = (fit.log_T > low) & (fit.log_T < high)
    moves = inside & (own > 0)
    jacobian = np.hstack([fit.curves[:, used], (fit.slopes * own)[:, moves]])
    errors = _standard_errors(jacobian)
    amplitude_error = np.full(used.size, np.nan)
    amplitude_error[used] = errors[: used.sum()]
    shape_error = np.full(own.size, np.nan)
    shape_error[moves] = errors[used.sum() :]
    status = "ok" if fit.converged else "not_converged"

    values = dict(
        zip(found.alphas, zip(fit.amplitudes, amplitude_error, strict=False), strict=False)
    )
    lines = []
    for alpha in sorted(wanted.alphas):
        h, error = values.get(alpha, (0.0, np.nan))
        name = f"h_{alpha}"
        if h > 0:
            lines.append(_detected(name, h, error, status))
        else:
            lines.append(_missing(name, limit(found.power[alpha], fit.residual, jacobian)))
    notes = []
    for k in range(fit.log_T.size):
        lines += _pair(
            f"q_c{k + 1}",
            f"T_c{k + 1}",
            own[k],
            amplitude_error[first + k],
            fit.log_T[k],
            shape_error[k],
            bool(inside[k]),
            status,
        )
    for k in range(fit.log_T.size, wanted.gauss_markov):
        at, upper = _likeliest(found.problem.table.T, fit.residual, jacobian)
        lines += [_missing(f"q_c{k + 1}", np.sqrt(upper)), _missing(f"T_c{k + 1}", np.nan)]
        T_c = np.exp(found.problem.log_T[at])
        notes.append(f"limit of q_c{k + 1} is for T_c = {T_c:.3g} s")
    if wanted.sinusoid:
        if fit.log_f is not None and own[-1] > 0:
            lines += _pair(
                "A_s", "f_0", own[-1], amplitude_error[-1], fit.log_f, shape_error[-1], True, status
            )
        else:
            at, upper = _likeliest(found.tones, fit.residual, jacobian)
            lines += [_missing("A_s", np.sqrt(upper)), _missing("f_0", np.nan)]
            notes.append(f"limit of A_s is for f_0 = {np.exp(found.log_f[at]):.3g} Hz")
    return tuple(lines), "; ".join(notes)


def _standard_errors(jacobian: np.ndarray) -> np.ndarray:
    """Roots of the diagonal of (J^T J)^-1; inf where the data do not tell."""
    if not jacobian.shape[1]:
        return np.empty(0)
    norm = np.linalg.norm(jacobian, axis=0)
    _, values, right = np.linalg.svd(jacobian / norm, full_matrices=False)
    with np.errstate(divide="ignore", over="ignore"):
        return np.sqrt(np.sum((right / values[:, None]) ** 2, axis=0)) / norm


def limit(column: np.ndarray, residual: np.ndarray, jacobian: np.ndarray) -> float:
    """One-sided 95 % limit of an amplitude that is not in the fit, all that is fitted free:
    max(0, estimate) + 1.645 standard errors."""
    return float(_limits(column[:, None], residual, jacobian)[1][0])


def _limits(
    columns: np.ndarray, residual: np.ndarray, jacobian: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(g,) significances and limits of the columns (k, g)."""
    new = projected(columns, jacobian)
    length = np.sqrt(np.einsum("ij,ij->j", new, new))
    with np.errstate(divide="ignore", invalid="ignore"):
        significance = np.nan_to_num((residual @ new) / length)
        return significance, (np.maximum(significance, 0.0) + ONE_SIDED_95) / length


def _likeliest(
    columns: np.ndarray, residual: np.ndarray, jacobian: np.ndarray
) -> tuple[int, float]:
    """Where among the columns one more component is likeliest, and its limit there."""
    significance, limits = _limits(columns, residual, jacobian)
    at = int(np.argmax(significance))
    return at, float(limits[at])


def _pair(
    amplitude: str,
    shape: str,
    square: float,
    square_error: float,
    log_shape: float,
    log_error: float,
    inside: bool,
    status: str,
) -> list[Coefficient]:
    """q_c and T_c, or A_s and f_0: the amplitude is the root of what was fitted."""
    root, value = float(np.sqrt(square)), float(np.exp(log_shape))
    return [
        _detected(amplitude, root, square_error / (2 * root), status),
        _detected(shape, value, value * log_error, status if inside else "at_bound"),
    ]


def _detected(name: str, value: float, error: float, status: str) -> Coefficient:
    value, error = float(value), float(error)
    ends = {}
    for label, z in (("68", Z_68), ("95", Z_95)):
        reach = z * error
        if error < value:
            low, high = value * np.exp(-reach / value), value * np.exp(reach / value)
        else:
            low, high = max(value - reach, 0.0), value + reach
        ends |= {f"lower_{label}": float(low), f"upper_{label}": float(high)}
    return Coefficient(name, value, error, **ends, status=status)


def _missing(name: str, upper: float) -> Coefficient:
    return Coefficient(name, np.nan, upper_95=float(upper), detected=False, status="not_detected")
