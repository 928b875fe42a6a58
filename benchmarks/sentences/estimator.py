"""S's estimator with and without descents: f_0 of lines.

The 28 lines that S prints for T40 and nine hours can tell, by `annealing-ant-colony` on the Allan
variances of `continuous` twins, with the seeds of config/twins.yaml; `-plain`, some ten seconds a
series, in runs of 100 or more only.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import yaml
from mocap_workflow.recording_twins import recording_twin

from benchmarks import ROOT
from benchmarks.sentences import Row
from mocap_metrology.common.hampel import hampel
from mocap_metrology.noise.allan.variance import allan_variance, averaging_factors
from mocap_metrology.noise.fit.allan.annealing import AnnealingRun, annealing_run, without_descents
from mocap_metrology.noise.fit.estimates import Estimate
from mocap_metrology.noise.fit.estimators import panel, published_estimate
from mocap_metrology.noise.twins.published import SERIES, printed_row, published_keys, published_row
from mocap_metrology.noise.twins.simulate import simulate
from mocap_metrology.settings import Annealing

RATE, NINE_HOURS_S = 120.0, 32400.0
WHOLE = 100  # runs from which slow cases are tried


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


def rows(n: int) -> Iterator[Row]:
    """Of the lines of `curves`; n decides whether `-plain` is tried."""
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
