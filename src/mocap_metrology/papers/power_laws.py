"""S Table 1: power-law noises and their Allan variance, printed beside computed and simulated;
and the white noise that S prints, by the number of cameras (S Figure 2)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from mocap_metrology.common.types import Row
from mocap_metrology.noise.model import scale_factors
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid
from mocap_metrology.noise.model.scale_factors import MU, PRINTED_D, printed_scale
from mocap_metrology.noise.twins.published import (
    FRAME_RATE_HZ,
    published_keys,
    published_power_laws,
    published_row,
)
from mocap_metrology.papers.subsets import NOT_FITTED, TYPES

FRAMES = np.array([20, 200, 2000])  # 10, 100 and 1000 periods of f_h
TAU_S = FRAMES * (1 / FRAME_RATE_HZ)
F_H = FRAME_RATE_HZ / 2
SAMPLES, REPEATS, SEED = 1 << 17, 64, 1935
COLOURS = {-2: "random walk", -1: "flicker (pink)", 0: "white", 1: "blue", 2: "violet"}
POINTS = {
    1: "a camera samples points: 1.038 becomes 2.683 from tau = 10 frames on",
    2: "a camera samples points: E is 2 ln 2 = 1.386 times as large",
}
NO_LIMIT = {
    0: "printed without limit; with f_h a share 3 / (2 pi^2 f_h tau) is missing",
    **dict.fromkeys((-1, -2), "printed without limit"),
}
Integrals = Mapping[float, np.ndarray]  # f_h -> (k, 2) Allan variances and bounds of their errors
RATE_HZ = 1000.0
TAU = np.geomspace(1e-3, 1e5, 2401)
RESOLVED = 6.0  # periods of a sinusoid up to which its bumps are drawn one by one


def table_1(repeats: int = REPEATS, samples: int = SAMPLES) -> list[Row]:
    """Rows of S Table 1, in long form: mu, the slope of the printed formula, K_alpha at three tau,
    and the 1.038 of D, each as printed, by integrals and by `repeats` simulations."""
    rows: list[Row] = []
    for entry in published_power_laws():
        alpha = int(entry["alpha"])
        limits = (math.inf, F_H) if alpha <= 0 else (F_H,)
        integrals = {
            f_h: np.array([scale_factors.integrated_avar(alpha, t, f_h) for t in TAU_S.tolist()])
            for f_h in limits
        }
        rng = np.random.default_rng(np.random.SeedSequence([SEED, alpha + 2]))
        simulated = scale_factors.simulated_avar(
            alpha, FRAMES, samples, FRAME_RATE_HZ, repeats, rng
        )
        head = {"noise": COLOURS[alpha], "alpha": alpha, "mu": int(entry["mu"])}
        head |= {"scale": entry["scale_name"], "formula": entry["scale_formula"]}
        parts = [*_slopes(alpha, integrals, simulated), *_scales(alpha, integrals, simulated)]
        if alpha == 1:
            parts += _constant_of_d(integrals[F_H], simulated)
        rows += [{**head, **row, "printed_line": entry["printed_line"]} for row in parts]
    return rows


def _slopes(alpha: int, integrals: Integrals, simulated: np.ndarray) -> Iterator[Row]:
    """mu; for blue noise also against the slope of the printed K_alpha(tau) tau^mu, another one."""
    weights = scale_factors.slope_weights(TAU_S)
    f_h, exact = next(iter(integrals.items()))
    slope = float(weights @ np.log(exact[:, 0]))
    bound = float(np.abs(weights) @ (exact[:, 1] / exact[:, 0]))
    expected = float(weights @ np.log(integrals[F_H][:, 0]))
    printed = {"mu": float(MU[alpha])}
    if alpha == 1:
        formula = [printed_scale(alpha, t, F_H) * t ** MU[alpha] for t in TAU_S.tolist()]
        printed["slope of K_alpha tau^mu"] = float(weights @ np.log(formula))
    for quantity, number in printed.items():
        blue = alpha == 1 and quantity == "mu"
        note = "K_alpha holds ln tau, so no power of tau is exact" if blue else ""
        yield _row(quantity, None, number, slope, bound, "integral", note, f_h=f_h)
        measured = scale_factors.slope_and_error(TAU_S, simulated)
        yield _row(quantity, None, number, *measured, "simulation", note, expected)


def _scales(alpha: int, integrals: Integrals, simulated: np.ndarray) -> Iterator[Row]:
    """K_alpha at every tau."""
    means, errors = scale_factors.mean_and_error(simulated)
    points = PowerLaw(alpha, 1.0).avar(FRAMES, FRAME_RATE_HZ, "sampled") if alpha > 0 else None
    for k, tau in enumerate(TAU_S.tolist()):
        unit = tau ** MU[alpha]
        place = "K_alpha", tau, printed_scale(alpha, tau, F_H)
        for f_h, exact in integrals.items():
            note = "for f_h tau >> 1" if alpha == 1 else ""
            note = NO_LIMIT[alpha] if alpha <= 0 and f_h == F_H else note
            value, error = (exact[k] / unit).tolist()
            yield _row(*place, value, error, "integral", note, f_h=f_h)
        expected = integrals[F_H][k, 0] / unit
        yield _row(*place, means[k] / unit, errors[k] / unit, "simulation", "", expected)
        if points is not None:
            yield _row(*place, points[k] / unit, None, "point samples", POINTS[alpha])


def _constant_of_d(exact: np.ndarray, simulated: np.ndarray) -> Iterator[Row]:
    """4 pi^2 K_1 - 3 ln(2 pi f_h tau), printed 1.038: at the longest tau by the integral, at the
    shortest, where it is surest, by simulation."""
    means, errors = scale_factors.mean_and_error(simulated)

    def constant(tau: float, avar: float) -> float:
        return 4 * math.pi**2 * tau**2 * avar - 3 * math.log(math.pi * FRAME_RATE_HZ * tau)

    first, *_, last = TAU_S.tolist()
    exactly = 3 * float(np.euler_gamma) - math.log(2)
    value, error = constant(last, exact[-1, 0]), 4 * math.pi**2 * last**2 * exact[-1, 1]
    place, note = ("constant of D", last, PRINTED_D), "3 gamma - ln 2 = 1.03850"
    # What is left is the formula's, not the quadrature's
    yield _row(*place, value, error, "integral", note, exactly) | {"errors_off": None}
    value, error = constant(first, means[0]), 4 * math.pi**2 * first**2 * errors[0]
    expected = constant(first, exact[0, 0])
    yield _row("constant of D", first, PRINTED_D, value, error, "simulation", "", expected)


def _row(
    quantity: str,
    tau_s: float | None,
    printed: float,
    value: float,
    error: float | None,
    method: str,
    note: str = "",
    expected: float | None = None,
    f_h: float = F_H,
) -> Row:
    return {
        **{"quantity": quantity, "tau_s": tau_s, "f_h_hz": None if math.isinf(f_h) else f_h},
        **{"published": printed, "regenerated": value, "standard_error": error},
        "expected": expected,
        "deviation_percent": 100 * (value / printed - 1) if printed else None,
        "errors_off": (value - expected) / error if expected is not None and error else None,
        "method": method,
        "source": "twin" if method == "simulation" else "computed",
        "note": note,
    }


def deviation(components: Sequence[PowerLaw | GaussMarkov | Sinusoid]) -> np.ndarray:
    """ADEV over TAU of a sum, continuous form; of a sinusoid past RESOLVED periods its mean over
    them, 3/8 of what the bumps reach."""
    broad = tuple(c for c in components if not isinstance(c, Sinusoid))
    avar = NoiseModel(broad).avar(TAU * RATE_HZ, RATE_HZ, "continuous")
    for line in (c for c in components if isinstance(c, Sinusoid)):
        exact = line.avar(TAU * RATE_HZ, RATE_HZ, "continuous")
        avar = avar + np.where(line.f_0 * TAU > RESOLVED, 3 / 8 * envelope(line) ** 2, exact)
    adev: np.ndarray = np.sqrt(avar)
    return adev


def slope_at(curve: np.ndarray, tau: float) -> float:
    """Log-log slope of a curve over TAU round tau: over an eighth of a decade to each side."""
    low, high = (int(np.abs(np.log(TAU / (tau * f))).argmin()) for f in (10**-0.125, 10**0.125))
    return float(np.log(curve[high] / curve[low]) / np.log(TAU[high] / TAU[low]))


def envelope(line: Sinusoid) -> np.ndarray:
    """What the bumps of a sinusoid reach: A sin^2(x)/x, x = pi f tau, up to the first, then A/x."""
    x = np.pi * line.f_0 * TAU
    return np.where(x < np.pi / 2, np.sin(x) ** 2, 1.0) * line.A_s / x


def white_level(model: NoiseModel) -> float:
    """h_0 and, in mm^2/Hz too, 2 (q_c T_c)^2 of correlated noise with T_c below a frame: the level
    that its density has at low frequencies."""
    level = 0.0
    for part in model.components:
        if isinstance(part, GaussMarkov) and part.T_c < 1 / FRAME_RATE_HZ:
            level += 2 * (part.q_c * part.T_c) ** 2
        elif isinstance(part, PowerLaw) and part.alpha == 0:
            level += part.h
    return level


def white_roots() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Camera type -> numbers of cameras and root of `white_level`, mm/sqrt(Hz), geometric mean over
    the six coordinates; without Vantage's ten."""
    roots = {}
    for kind in TYPES:
        counts = sorted(n for k, n in published_keys() if k == kind and (k, n) != NOT_FITTED)
        levels = [
            [white_level(model) for s, model in published_row(kind, n).items() if s != "L"]
            for n in counts
        ]
        roots[kind] = np.array(counts), np.exp(np.mean(np.log(levels), axis=1) / 2)
    return roots
