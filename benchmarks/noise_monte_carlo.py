"""How exact the estimators of noise coefficients are, against the Cramer-Rao bound.

    python benchmarks/noise_monte_carlo.py               # 1000 runs of the likelihood, minutes
    python benchmarks/noise_monte_carlo.py --full 100    # whole series, cleaning, every estimator

Truth: rows of Tables A1-A3 of Skurowski & Pawlyta 2019, nine hours at 120 Hz, without the
components of which nine hours cannot tell a coefficient to within half its value (`--limit`). The
first kind of run draws the binned periodogram from its distribution; the second simulates the
series, stores it as a file would (float32), cleans it as the workflow does, and fits. Printed as
Markdown: RMSE over the bound, bias in bounds, and the share of 68 % and 95 % intervals that hold
the truth; Gauss-Markov terms are paired with the true ones by T_c, within a factor of three.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import os
import sys
from collections import defaultdict

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from scipy.optimize import linear_sum_assignment

from mocap_metrology.noise.fit.estimates import Coefficient, Components, Estimate
from mocap_metrology.noise.fit.spectral.intervals import coefficients
from mocap_metrology.noise.fit.spectral.order import choose, fit_known
from mocap_metrology.noise.fit.spectral.periodogram import Periodogram, bins_of
from mocap_metrology.noise.fit.spectral.whittle import Likelihood, crlb, spectrum_of
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.published import published_row

RATE, FRAMES = 120.0, 3_888_000
ROWS = (("T40", 10), ("Bonita", 10), ("Vantage", 9))
SERIES = "x1"
HEAD = ("coefficient", "truth", "CRLB/truth", "found in", "RMSE/CRLB", "bias/CRLB")
COVER = ("in 68 %", "in 95 %")
PAIRED_WITHIN = 3.0  # factor between two T_c that are taken for one


def truth_of(row: tuple[str, int], limit: float) -> NoiseModel:
    """The part of the published row that nine hours can tell."""
    return tellable(published_row(*row)[SERIES], FRAMES, RATE, limit).ordered()


def tellable(model: NoiseModel, n: int, frame_rate_hz: float, limit: float) -> NoiseModel:
    """The model without the components that n samples cannot determine.

    The component of the greatest relative bound (of h, q_c or T_c) is removed while it exceeds
    `limit`, and the bounds are computed afresh. Lines stay.
    """
    left = model
    while True:
        values, bounds = left.coefficients(), crlb(left, n, frame_rate_hz)
        relative = {
            name: bounds[name] / values[name] if values[name] else math.inf
            for name in bounds
            if name not in ("A_s", "f_0")
        }
        worst = max(relative, key=lambda name: relative[name], default=None)
        if worst is None or relative[worst] <= limit:
            return left
        number = worst[3:]
        same = {worst} if worst[0] == "h" else {f"q_c{number}", f"T_c{number}"}
        kept = {k: v for k, v in values.items() if k not in same}
        left = NoiseModel.from_coefficients(kept, model.form)


def binned_run(job: tuple[tuple[str, int], NoiseModel, int]) -> dict[str, Estimate]:
    """One periodogram drawn from its distribution; order known and chosen by BIC."""
    row, truth, seed = job
    components = Components.of(truth)
    bins = bins_of(FRAMES, RATE)
    weight = bins.n.astype(float)
    bounds = bins.T_c_range
    expected = Likelihood(Periodogram(bins, np.ones(weight.size), weight), bounds).density(
        spectrum_of(truth)
    )
    rng = np.random.default_rng([seed, *row[0].encode()])
    data = Periodogram(bins, expected * rng.chisquare(weight) / weight, weight)
    likelihood = Likelihood(data, bounds)
    known = fit_known(likelihood, components.alphas, components.gauss_markov)
    chosen = choose(likelihood, (-2, -1, 0, 1, 2), 4)
    return {
        "likelihood, order known": _estimate(data, known, components),
        "likelihood, order by BIC": _estimate(data, chosen, None),
    }


def _estimate(data: Periodogram, fit, components: Components | None) -> Estimate:
    found = coefficients(data, fit, None, components, 4, False)
    return Estimate("likelihood", "sampled", found, fit.deviance)


def full_run(job: tuple[tuple[str, int], NoiseModel, int]) -> list[dict[str, Estimate]]:
    """Two whole series of one row, cleaned and fitted as the workflow does."""
    from mocap_metrology.noise.model.synthesis import Cross, draw_pair

    row, truth, seed = job
    rng = np.random.default_rng([seed, *row[0].encode()])
    pair = draw_pair(truth, truth, Cross(constant=0.0), FRAMES, RATE, rng)
    return [_fit_series(series.astype(np.float32).astype(float), truth, seed) for series in pair]


def _fit_series(series: np.ndarray, truth: NoiseModel, seed: int) -> dict[str, Estimate]:
    from mocap_metrology.common.hampel import hampel
    from mocap_metrology.noise.allan.confidence import allan_curve
    from mocap_metrology.noise.allan.variance import averaging_factors
    from mocap_metrology.noise.fit.allan.annealing import annealing_run
    from mocap_metrology.noise.fit.spectral.likelihood import likelihood
    from mocap_metrology.settings import Annealing

    components = Components.of(truth)
    masked = hampel(series, 120, 6.0, "mask").values
    m = averaging_factors(FRAMES, 100, 1, 1 / 3)
    cleaned = allan_curve(hampel(series, 120, 3.0, "replace").values, RATE, m)
    return {
        "likelihood, order known": likelihood(masked, RATE, components).estimate,
        "likelihood, order by BIC": likelihood(masked, RATE).estimate,
        "annealing-ant-colony, order known (3-sigma cleaned, continuous)": annealing_run(
            cleaned.m, cleaned.variance, RATE, components, Annealing(), seed
        ).estimate,
    }


def report(row: tuple[str, int], truth: NoiseModel, runs: list[dict[str, Estimate]]) -> None:
    """Tables of one row, one an estimator."""
    print(f"\n## {row[0]} {SERIES}, {row[1]} cameras: {len(runs)} runs\n")
    for estimator in runs[0]:
        print(f"**{estimator}**\n")
        print(_table([_paired(run[estimator], truth) for run in runs], truth))
        print(_orders([run[estimator] for run in runs], set(truth.coefficients())))


def _paired(estimate: Estimate, truth: NoiseModel) -> dict[str, Coefficient]:
    """Coefficients under the names of the true ones they stand for."""
    found = {c.parameter: c for c in estimate.coefficients if c.detected and c.value > 0}
    out = {name: c for name, c in found.items() if name[0] == "h"}
    true = {k: v for k, v in truth.coefficients().items() if k.startswith("T_c")}
    own = {k: c.value for k, c in found.items() if k.startswith("T_c")}
    if true and own:
        apart = np.abs(np.log(np.array([*true.values()])[:, None] / np.array([*own.values()])))
        for i, j in zip(*linear_sum_assignment(np.minimum(apart, 10)), strict=True):
            if apart[i, j] <= np.log(PAIRED_WITHIN):
                theirs, mine = list(true)[i], list(own)[j]
                out[theirs] = found[mine]
                out[theirs.replace("T_c", "q_c")] = found[mine.replace("T_c", "q_c")]
    return out


def _table(runs: list[dict[str, Coefficient]], truth: NoiseModel) -> str:
    head = HEAD + COVER
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    bounds = crlb(truth, FRAMES, RATE)
    for name, true in truth.coefficients().items():
        found = [run[name] for run in runs if name in run]
        cells = [f"{name} | {true:.3g} | {100 * bounds[name] / true:.2g} %"]
        cells.append(f"{100 * len(found) / len(runs):.1f} %")
        if found:
            error = np.array([c.value - true for c in found]) / bounds[name]
            cells += [f"{np.sqrt(np.mean(error**2)):.3f}", f"{error.mean():+.3f}"]
            if np.isfinite(found[0].lower_68):
                cells.append(
                    f"{100 * np.mean([c.lower_68 <= true <= c.upper_68 for c in found]):.1f}"
                )
                cells.append(
                    f"{100 * np.mean([c.lower_95 <= true <= c.upper_95 for c in found]):.1f}"
                )
        cells += [""] * (len(head) - 3 - len(cells))
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _orders(runs: list[Estimate], true: set[str]) -> str:
    counts: dict[str, int] = defaultdict(int)
    for run in runs:
        names = {c.parameter for c in run.coefficients if c.detected and c.value > 0}
        missing, more = " ".join(sorted(true - names)), " ".join(sorted(names - true))
        counts[f"without {missing or 'none'}, with {more or 'none'} more"] += 1
    listed = sorted(counts.items(), key=lambda item: -item[1])[:4]
    return "Components: " + "; ".join(f"{100 * n / len(runs):.1f} % {k}" for k, n in listed) + "\n"


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--runs", type=int, default=1000, help="binned runs a row (1000)")
    parser.add_argument("--full", type=int, default=0, help="runs with whole series a row (0)")
    parser.add_argument("--limit", type=float, default=0.5, help="greatest relative bound (0.5)")
    parser.add_argument("--seed", type=int, default=1, help="first seed (1)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (2)")
    options = parser.parse_args()
    with multiprocessing.get_context("spawn").Pool(options.jobs) as pool:
        for row in ROWS:
            truth = truth_of(row, options.limit)
            if options.full:
                jobs = [(row, truth, options.seed + k) for k in range((options.full + 1) // 2)]
                runs = [run for pair in _watched(pool, full_run, jobs) for run in pair]
            else:
                jobs = [(row, truth, options.seed + k) for k in range(options.runs)]
                runs = list(_watched(pool, binned_run, jobs))
            report(row, truth, runs)


def _watched(pool, function, jobs):
    """Results as they come, with the count on standard error."""
    for done, result in enumerate(pool.imap(function, jobs), start=1):
        if done % max(len(jobs) // 20, 1) == 0:
            print(f"{jobs[0][0]}: {done} of {len(jobs)}", file=sys.stderr, flush=True)
        yield result


if __name__ == "__main__":
    main()
