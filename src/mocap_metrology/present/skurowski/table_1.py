"""S Table 1: power-law noises and their Allan variance, printed beside computed and simulated."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mocap_metrology.noise.model.scale_factors import (
    MU,
    PRINTED_D,
    camera_avar,
    integrated_avar,
    mean_and_error,
    printed_scale,
    simulated_avar,
    slope_and_error,
    slope_weights,
)
from mocap_metrology.noise.twins.published import FRAME_RATE_HZ, published_power_laws
from mocap_metrology.present.tables import Row

FACTORS = (20, 200, 2000)  # tau in frames: 10, 100 and 1000 periods of f_h
SAMPLES, REPEATS, SEED = 1 << 17, 64, 1935
COLOURS = {-2: "random walk", -1: "flicker (pink)", 0: "white", 1: "blue", 2: "violet"}
CAPTION = (
    "Allan variance of S(f) = h f^alpha: h K_alpha tau^mu, its deviation varies as tau^(mu/2). All "
    "values are for h = 1 and f_h = 60 Hz (half the frame rate; S states none). method: "
    "integral, the integral over the power law by scipy.integrate.quad (no f_h: without limit); "
    "simulation, mean of 64 simulated series of 131 072 averages over 1/120 s, overlapping Allan "
    "variance; point samples, exact values for a camera, which samples points instead of "
    "averages. standard_error: of the mean of the simulations; of an integral, a bound of its "
    "numerical error. expected: the exact mean of the simulations; errors_off: their deviation "
    "from it in standard errors. deviation_percent: deviation from the printed number."
)
SHOWN = (
    *("noise", "alpha", "scale", "formula", "quantity", "tau_s", "f_h_hz", "published"),
    *("regenerated", "standard_error", "expected", "deviation_percent", "errors_off", "method"),
    *("source", "note"),
)


@dataclass(frozen=True)
class Noise:
    """A row of Table 1 as printed."""

    alpha: int
    entry: dict[str, str]

    @property
    def head(self) -> Row:
        return {
            "noise": COLOURS[self.alpha],
            "alpha": self.alpha,
            "mu": int(self.entry["mu"]),
            "scale": self.entry["scale_name"],
            "formula": self.entry["scale_formula"],
        }

    @property
    def printed_line(self) -> str:
        return self.entry["printed_line"]


def table_1(repeats: int = REPEATS, samples: int = SAMPLES, seed: int = SEED) -> list[Row]:
    """Rows of S Table 1, in long form: mu, the slope of the printed formula, K_alpha at three tau,
    and the 1.038 of D."""
    rows: list[Row] = []
    tau0 = 1 / FRAME_RATE_HZ
    m = np.array(FACTORS)
    for entry in published_power_laws():
        noise = Noise(int(entry["alpha"]), entry)
        words = np.random.SeedSequence([seed, noise.alpha + 2])
        avar = simulated_avar(
            noise.alpha, m, samples, FRAME_RATE_HZ, repeats, np.random.default_rng(words)
        )
        rows += _of_noise(noise, m * tau0, m, avar)
    return rows


def _of_noise(noise: Noise, tau: np.ndarray, m: np.ndarray, avar: np.ndarray) -> list[Row]:
    f_h = FRAME_RATE_HZ / 2
    alpha, mu = noise.alpha, MU[noise.alpha]
    limits = (math.inf, f_h) if alpha <= 0 else (f_h,)
    exact = {limit: [integrated_avar(alpha, float(t), limit) for t in tau] for limit in limits}
    made = [*_slopes(noise, tau, exact, avar)]
    for k, t in enumerate(tau.tolist()):
        printed = printed_scale(alpha, t, f_h)
        unit = t**mu
        for limit in limits:
            value, error = exact[limit][k]
            note = _note(alpha, limit)
            made.append(
                _row(noise, "K_alpha", t, printed, value / unit, error / unit, "integral", note)
                | {"f_h_hz": None if math.isinf(limit) else limit}
            )
        mean, error = (v[k] / unit for v in mean_and_error(avar))
        wanted = exact[f_h][k][0] / unit
        made.append(_row(noise, "K_alpha", t, printed, mean, error, "simulation", "", wanted))
        if alpha > 0:
            camera = camera_avar(alpha, m, FRAME_RATE_HZ)[k] / unit
            note = "a camera samples points: " + POINTS[alpha]
            made.append(_row(noise, "K_alpha", t, printed, camera, None, "point samples", note))
    if alpha == 1:
        made += _constant_of_d(noise, tau, exact[f_h], avar)
    return made


POINTS = {
    1: "1.038 becomes 2.683 from tau = 10 frames on",
    2: "E is 2 ln 2 = 1.386 times as large",
}


def _note(alpha: int, limit: float) -> str:
    if alpha == 0 and not math.isinf(limit):
        return "printed without limit; with f_h a share 3 / (2 pi^2 f_h tau) is missing"
    if alpha < 0 and not math.isinf(limit):
        return "printed without limit"
    return "for f_h tau >> 1" if alpha == 1 else ""


def _slopes(
    noise: Noise,
    tau: np.ndarray,
    exact: dict[float, list[tuple[float, float]]],
    avar: np.ndarray,
) -> Iterator[Row]:
    """mu; for blue noise also against the slope of the printed K_alpha(tau) tau^mu, another one."""
    alpha, f_h = noise.alpha, FRAME_RATE_HZ / 2
    weights = slope_weights(tau)
    whole = [printed_scale(alpha, float(t), f_h) * float(t) ** MU[alpha] for t in tau]
    formula = float(weights @ np.log(whole))
    limit = next(iter(exact))
    values, errors = np.array(exact[limit]).T
    slope = float(weights @ np.log(values))
    bound = float(np.abs(weights) @ (errors / values))
    found, error = slope_and_error(tau, avar)
    wanted = float(weights @ np.log([value for value, _ in exact[f_h]]))
    note = "K_alpha holds ln tau, so no power of tau is exact" if alpha == 1 else ""
    printed_slopes = {"mu": float(MU[alpha])}
    if alpha == 1:
        printed_slopes["slope of K_alpha tau^mu"] = formula
    for quantity, printed in printed_slopes.items():
        shown = note if quantity == "mu" else ""
        row = _row(noise, quantity, None, printed, slope, bound, "integral", shown)
        yield row | {"f_h_hz": None if math.isinf(limit) else limit}
        yield _row(noise, quantity, None, printed, found, error, "simulation", shown, wanted)


def _constant_of_d(
    noise: Noise, tau: np.ndarray, exact: list[tuple[float, float]], avar: np.ndarray
) -> list[Row]:
    """4 pi^2 K_1 - 3 ln(2 pi f_h tau), printed 1.038: at the longest tau by the integral, at the
    shortest, where it is surest, by simulation."""
    rows = []
    exactly = 3 * float(np.euler_gamma) - math.log(2)
    mean, error = mean_and_error(avar)
    for k, method, value, spread, note in (
        (-1, "integral", *exact[-1], "3 gamma - ln 2 = 1.03850"),
        (0, "simulation", float(mean[0]), float(error[0]), ""),
    ):
        t = float(tau[k])
        unit = 4 * math.pi**2 * t**2
        found = unit * value - 3 * math.log(math.pi * FRAME_RATE_HZ * t)
        wanted = unit * exact[k][0] - 3 * math.log(math.pi * FRAME_RATE_HZ * t)
        wanted = exactly if method == "integral" else wanted
        rows.append(
            _row(noise, "constant of D", t, PRINTED_D, found, unit * spread, method, note, wanted)
        )
        if method == "integral":  # what is left is the formula's, not the quadrature's
            rows[-1]["errors_off"] = None
    return rows


def _row(
    noise: Noise,
    quantity: str,
    tau: float | None,
    printed: float,
    value: float,
    error: float | None,
    method: str,
    note: str = "",
    expected: float | None = None,
) -> Row:
    rest: Row = {
        "f_h_hz": FRAME_RATE_HZ / 2,
        "published": printed,
        "regenerated": value,
        "standard_error": error,
        "expected": expected,
        "deviation_percent": 100 * (value / printed - 1) if printed else None,
        "errors_off": (value - expected) / error if expected is not None and error else None,
        "method": method,
        "source": "twin" if method == "simulation" else "computed",
        "note": note,
        "printed_line": noise.printed_line,
    }
    return {**noise.head, "quantity": quantity, "tau_s": tau, **rest}
