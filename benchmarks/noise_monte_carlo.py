"""How exact the estimators of noise coefficients are, against the Cramer-Rao bound.

    python -m benchmarks.noise_monte_carlo               # 1000 runs of the likelihood, minutes
    python -m benchmarks.noise_monte_carlo --full 100    # whole series, cleaning, every estimator

Truth: rows of Tables A1-A3 of Skurowski & Pawlyta 2019, nine hours at 120 Hz, without the
components of which nine hours cannot tell a coefficient to within half its value. The first kind
of run draws the binned periodogram from its distribution; the second simulates the series, stores
it as a file would (float32), cleans it as the workflow does, and fits. Printed as Markdown: RMSE
over the bound, bias in bounds, and the share of 68 % and 95 % intervals that hold the truth;
Gauss-Markov terms are paired with the true ones by T_c, within a factor of three.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import sys
from collections import Counter

import numpy as np

from benchmarks import head, line
from benchmarks.sentences.models import NINE_HOURS as FRAMES
from benchmarks.sentences.models import RATE, drawn, paired
from mocap_metrology.common.hampel import hampel
from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.fit.allan.annealing import annealing_run
from mocap_metrology.noise.fit.estimates import Coefficient, Components, Estimate
from mocap_metrology.noise.fit.spectral.intervals import coefficients
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.fit.spectral.order import choose, fit_known
from mocap_metrology.noise.fit.spectral.periodogram import Periodogram
from mocap_metrology.noise.fit.spectral.whittle import Likelihood, crlb
from mocap_metrology.noise.model.components import ALPHAS, NoiseModel
from mocap_metrology.noise.model.synthesis import Cross, draw_pair
from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.settings import Annealing

ROWS = (("T40", 10), ("Bonita", 10), ("Vantage", 9))
SERIES = "x1"
LIMIT = 0.5  # greatest relative bound
HEAD = ("coefficient", "truth", "CRLB/truth", "found in", "RMSE/CRLB", "bias/CRLB")
COVER = ("in 68 %", "in 95 %")
Job = tuple[tuple[str, int], NoiseModel, int]  # row, truth, seed


def tellable(model: NoiseModel) -> NoiseModel:
    """The model without the components that nine hours cannot determine.

    The component of the greatest relative bound (of h, q_c or T_c) is removed while it exceeds
    LIMIT, and the bounds are computed afresh. Lines stay.
    """
    left = model
    while True:
        values, bounds = left.coefficients(), crlb(left, FRAMES, RATE)
        relative = {
            name: bounds[name] / values[name] if values[name] else math.inf
            for name in bounds
            if name not in ("A_s", "f_0")
        }
        worst = max(relative, key=lambda name: relative[name], default=None)
        if worst is None or relative[worst] <= LIMIT:
            return left
        number = worst[3:]
        same = {worst} if worst[0] == "h" else {f"q_c{number}", f"T_c{number}"}
        kept = {k: v for k, v in values.items() if k not in same}
        left = NoiseModel.from_coefficients(kept, model.form)


def binned_run(job: Job) -> list[dict[str, Estimate]]:
    """One periodogram drawn from its distribution; order known and chosen by BIC."""
    row, truth, seed = job
    components = Components.of(truth)
    data = drawn(truth, FRAMES, RATE, [seed, *row[0].encode()])
    model = Likelihood(data, data.bins.T_c_range)
    known = fit_known(model, components.alphas, components.gauss_markov)
    return [
        {
            "likelihood, order known": _estimate(data, known, components),
            "likelihood, order by BIC": _estimate(data, choose(model, ALPHAS, 4), None),
        }
    ]


def _estimate(data: Periodogram, fit, components: Components | None) -> Estimate:
    found = coefficients(data, fit, None, components, 4, False)
    return Estimate("likelihood", "sampled", found, fit.deviance)


def full_run(job: Job) -> list[dict[str, Estimate]]:
    """Two whole series of one row, cleaned and fitted as the workflow does."""
    row, truth, seed = job
    rng = np.random.default_rng([seed, *row[0].encode()])
    pair = draw_pair(truth, truth, Cross(constant=0.0), FRAMES, RATE, rng)
    return [_fit_series(series.astype(np.float32).astype(float), truth, seed) for series in pair]


def _fit_series(series: np.ndarray, truth: NoiseModel, seed: int) -> dict[str, Estimate]:
    components = Components.of(truth)
    masked = hampel(series, 120, 6.0, "mask").values
    m = averaging_factors(FRAMES, 100, 1, 1 / 3)
    cleaned = allan_curve(hampel(series, 120, 3.0, "replace").values, RATE, m)
    points = cleaned.m, cleaned.variance, RATE, components
    return {
        "likelihood, order known": likelihood(masked, RATE, components).estimate,
        "likelihood, order by BIC": likelihood(masked, RATE).estimate,
        "annealing-ant-colony, order known (3-sigma cleaned, continuous)": annealing_run(
            *points, Annealing(), seed
        ).estimate,
    }


def report(row: tuple[str, int], truth: NoiseModel, runs: list[dict[str, Estimate]]) -> None:
    """Tables of one row, one an estimator."""
    print(f"\n## {row[0]} {SERIES}, {row[1]} cameras: {len(runs)} runs\n")
    for estimator in runs[0]:
        print(f"**{estimator}**\n")
        _table([_named(run[estimator], truth) for run in runs], truth)
        counts: Counter[str] = Counter()
        true = set(truth.coefficients())
        for run in runs:
            names = set(_detected(run[estimator]))
            missing, more = " ".join(sorted(true - names)), " ".join(sorted(names - true))
            counts[f"without {missing or 'none'}, with {more or 'none'} more"] += 1
        shares = (f"{100 * n / len(runs):.1f} % {k}" for k, n in counts.most_common(4))
        print("\nComponents: " + "; ".join(shares) + "\n")


def _detected(estimate: Estimate) -> dict[str, Coefficient]:
    return {c.parameter: c for c in estimate.coefficients if c.detected and c.value > 0}


def _named(estimate: Estimate, truth: NoiseModel) -> dict[str, Coefficient]:
    """Coefficients under the names of the true ones they stand for."""
    found = _detected(estimate)
    out = {name: c for name, c in found.items() if name[0] == "h"}
    for mine, theirs in paired({k: c.value for k, c in found.items()}, truth.coefficients()):
        for kind in ("T_c", "q_c"):
            out[theirs.replace("T_c", kind)] = found[mine.replace("T_c", kind)]
    return out


def _table(runs: list[dict[str, Coefficient]], truth: NoiseModel) -> None:
    columns = HEAD + COVER
    head(*columns)
    bounds = crlb(truth, FRAMES, RATE)
    for name, true in truth.coefficients().items():
        found = [run[name] for run in runs if name in run]
        share = f"{100 * len(found) / len(runs):.1f} %"
        cells = [name, f"{true:.3g}", f"{100 * bounds[name] / true:.2g} %", share]
        if found:
            error = np.array([c.value - true for c in found]) / bounds[name]
            cells += [f"{np.sqrt(np.mean(error**2)):.3f}", f"{error.mean():+.3f}"]
            if np.isfinite(found[0].lower_68):
                inside = [
                    (c.lower_68 <= true <= c.upper_68, c.lower_95 <= true <= c.upper_95)
                    for c in found
                ]
                cells += [f"{100 * held:.1f}" for held in np.mean(inside, axis=0)]
        line(*cells, *[""] * (len(columns) - len(cells)))


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--runs", type=int, default=1000, help="binned runs a row (1000)")
    parser.add_argument("--full", type=int, default=0, help="runs with whole series a row (0)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (2)")
    options = parser.parse_args()
    run, seeds = binned_run, range(1, 1 + options.runs)
    if options.full:
        run, seeds = full_run, range(1, 1 + (options.full + 1) // 2)
    with multiprocessing.get_context("spawn").Pool(options.jobs) as pool:
        for row in ROWS:
            truth, runs = tellable(published_row(*row)[SERIES]).ordered(), []
            for found in pool.imap(run, [(row, truth, seed) for seed in seeds]):
                runs += found
                if len(runs) % 50 == 0:
                    print(f"{row}: {len(runs)} runs", file=sys.stderr, flush=True)
            report(row, truth, runs)


if __name__ == "__main__":
    main()
