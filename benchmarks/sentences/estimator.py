"""Chi-squared test of a Gaussian (`gaussian.csv`); S's estimator with and without descents.

p of the chi-squared test must be uniform where the noise is Gaussian, whatever its time scales: of
the distance in twins of all 22 published rows, 15 minutes long (and nine hours, in whole runs), as
drawn and as the 3-sigma filter leaves it. What is not Gaussian must be rejected still: frames of 15
minutes with tails or two levels, alone and under slow noise. f_0: the 28 lines that S prints
for T40 and nine hours can tell, by `annealing-ant-colony` on the Allan variances of `continuous`
twins, with the seeds of config/twins.yaml; `-plain`, some ten seconds a series, in whole runs only.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import yaml
from mocap_workflow.recording_twins import recording_twin, twin_from_mapping
from scipy.stats import kstest

from benchmarks import ROOT
from benchmarks.sentences import Row
from benchmarks.sentences._kinds import gauss_markov
from mocap_metrology.common.hampel import hampel
from mocap_metrology.noise.allan.variance import allan_variance, averaging_factors
from mocap_metrology.noise.fit.allan.annealing import AnnealingRun, annealing_run, without_descents
from mocap_metrology.noise.fit.estimates import Estimate
from mocap_metrology.noise.fit.estimators import panel, published_estimate
from mocap_metrology.noise.gaussian.two_markers import chi_squared_normal
from mocap_metrology.noise.twins.published import SERIES, printed_row, published_keys, published_row
from mocap_metrology.noise.twins.simulate import simulate
from mocap_metrology.settings import Annealing

RATE = 120.0
TAU0 = 1 / RATE
QUARTER_S, NINE_HOURS_S = 900.0, 32400.0
WHOLE = 100  # runs from which nine-hour and slow cases are tried


def rows(n: int) -> Iterator[Row]:
    """All cases, n recordings each where chance matters."""
    yield from _uniform(n)
    yield from _power(n)
    yield from _lines(n)


def p_value(series: np.ndarray) -> float:
    """Of a series against N(its mean, its standard deviation)."""
    return chi_squared_normal(series, series.mean(), series.std(ddof=1)).p_value


def distance(kind: str, n_cameras: int, seed: int, duration_s: float) -> np.ndarray:
    """L of a twin of a published row."""
    entry = {"published": {"camera_type": kind, "n_cameras": n_cameras}, "seed": seed}
    position = simulate(twin_from_mapping(entry, f"{kind}-{n_cameras}"), duration_s).position_mm
    return np.sqrt(np.sum((position[0] - position[1]) ** 2, axis=0))


def _uniform(n: int) -> Iterator[Row]:
    seeds = math.ceil(n / len(published_keys()))
    cases = [("15 min", QUARTER_S, seeds)] + [("nine hours", NINE_HOURS_S, 1)] * (n >= WHOLE)
    for length, duration_s, count in cases:
        drawn: list[float] = []
        filtered: list[float] = []
        for seed in range(count):
            for key in published_keys():
                L = distance(*key, 100 + seed, duration_s)
                drawn.append(p_value(L))
                filtered.append(p_value(hampel(L, 120, 3.0, "replace", 0.0).values))
        for how, p in (("as drawn", drawn), ("filtered", filtered)):
            known = np.array(p)[np.isfinite(p)]
            said = f"{kstest(known, 'uniform').pvalue:.2g} ({np.mean(known < 0.05):.0%} below 0.05)"
            case = f"Gaussian twins of the published rows, {length}, {how}"
            yield case, "Kolmogorov-Smirnov p of uniform p", len(p), "> 0.01", said


SLOW = {"alone": None, "30 % of T_c 10 s": (10.0, 0.3), "9 % of T_c 60 s": (60.0, 0.09)}


def _power(n: int) -> Iterator[Row]:
    """Frames of variance 1 of several distributions, and slow Gauss-Markov noise under them."""
    size = round(QUARTER_S * RATE)
    draws = {
        "Gaussian": lambda rng: rng.standard_normal(size),
        "Student t5": lambda rng: rng.standard_t(5, size) / np.sqrt(5 / 3),
        "Student t10": lambda rng: rng.standard_t(10, size) / np.sqrt(10 / 8),
        "uniform": lambda rng: rng.uniform(-1, 1, size) * np.sqrt(3),
        "two levels": lambda rng: (
            (rng.standard_normal(size) + 1.5 * rng.choice([-1, 1], size)) / np.sqrt(3.25)
        ),
    }
    for under, slow in SLOW.items():
        for name, draw in draws.items():
            rejected = 0
            for seed in range(n):
                rng = np.random.default_rng([7, seed])
                series = draw(rng)
                if slow is not None:
                    T_c, share = slow
                    noise = gauss_markov(T_c, np.sqrt(share))(rng, size, RATE)
                    series = np.sqrt(1 - share) * series + noise
                rejected += p_value(series) < 0.05
            reach = "<= 10 %" if name == "Gaussian" else "as before or more"
            yield f"{name}, {under}", "rejected at 5 %", n, reach, f"{100 * rejected / n:.0f} %"


def curves() -> Iterator[tuple[int, str, np.ndarray, np.ndarray]]:
    """(cameras, series, m, cleaned AVAR) of every line of T40 that nine hours can tell."""
    document = yaml.safe_load((ROOT / "config/twins.yaml").read_text(encoding="utf-8"))
    common = document["defaults"]["recording"]
    twins = {
        name: recording_twin(entry, name, common)
        for name, entry in document["twins"].items()
        if "published" in entry
    }
    frames = round(NINE_HOURS_S * RATE)
    m = averaging_factors(frames, 100, 1, 1 / 3)
    for _, n in (key for key in published_keys() if key[0] == "T40"):
        models = published_row("T40", n)
        told = [s for s in SERIES if models[s].lines and _supported(models[s], frames)]
        position = simulate(replace(twins[f"T40-{n}"], form="continuous"), NINE_HOURS_S).position_mm
        for series in told:
            if series == "L":
                values = np.sqrt(np.sum((position[0] - position[1]) ** 2, axis=0))
            else:
                values = position[int(series[1]) - 1, "xyz".index(series[0])]
            cleaned = hampel(values, 120, 3.0, "replace", 0.0).values
            yield n, series, m, allan_variance(cleaned, m).variance


def _supported(model, frames: int) -> bool:
    found = {c.parameter: c for c in published_estimate(model, frames, RATE).coefficients}
    return bool(found["f_0"].crlb <= found["f_0"].value)


def _run(fit: tuple, settings: Annealing) -> AnnealingRun:
    return annealing_run(*fit, settings, 1, "continuous", NINE_HOURS_S)


def _near(estimate: Estimate, printed: float) -> bool:
    return bool(abs(estimate.values["f_0"] / printed - 1) < 0.1)


def _lines(n: int) -> Iterator[Row]:
    hits, every, plain_hits, total = 0, 0, 0, 0
    cost, white, gain = [], [], []
    settings = Annealing()
    all_tau = settings.model_copy(update={"longest_tau_share": 1.0})
    for cameras, series, m, avar in curves():
        printed = printed_row("T40", cameras)[series]["f_0"]
        fit = m, avar, RATE, panel("T40", cameras, series)
        best = _run(fit, settings).estimate
        hits += _near(best, printed)
        every += _near(_run(fit, all_tau).estimate, printed)
        total += 1
        if n >= WHOLE:
            one = _run(fit, without_descents(settings))
            plain = one.estimate
            gain.append(one.colony_gain)
            plain_hits += _near(plain, printed)
            cost.append(plain.cost / best.cost)
            white.append(abs(plain.values["h_0"] / best.values["h_0"] - 1))
    told = "f_0 within 10 % of print"
    yield "annealing-ant-colony", told, total, ">= 16", f"{hits} of {total}"
    yield "the same, every tau fitted", told, total, "-", f"{every} of {total}"
    if n >= WHOLE:
        name = "annealing-ant-colony-plain"
        low, half, high = np.quantile(gain, [0.1, 0.5, 0.9])
        for statistic, measured in (
            (told, f"{plain_hits} of {total}"),
            ("cost over that with descents",
             f"{np.median(cost):.2f}, 90 %: {np.quantile(cost, 0.9):.1f}"),
            ("best start's cost over the colony's", f"{half:.2f} ({low:.2f} to {high:.2f})"),
            ("h_0 off from that with descents",
             f"{100 * np.median(white):.0f} %, 90 %: {100 * np.quantile(white, 0.9):.0f} %"),
        ):  # fmt: skip
            yield name, statistic, total, "-", measured
