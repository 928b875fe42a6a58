"""Claims of S 3.5, 4.2, 4.3 and 4.4 on Allan deviations and on the Gaussian model.

Those that one recording cannot decide are held against many realisations of its twins.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from mocap_metrology.noise.gaussian.moments import Cleaning
from mocap_metrology.noise.twins.published import SERIES
from mocap_metrology.noise.twins.twin import Twin
from mocap_metrology.present.claims.claim import (
    COORDINATES,
    DOES_NOT,
    HOLDS,
    TYPES,
    UNKNOWN,
    Claim,
    Drawn,
    Finding,
    Key,
    Missing,
    Study,
    by_count,
    decided,
    model_of,
    share,
    subsets,
    unknown,
    whole,
)
from mocap_metrology.present.skurowski.gaussian_table import realisations

SHORT_S = np.geomspace(0.01, 0.1, 7)
LONG_S = np.geomspace(1.0, 1000.0, 10)
ALL_S = np.geomspace(0.01, 1000.0, 26)
SLOPES = (-1.0, -0.5, 0.0, 0.5)


def _reaches(study: Study, *keys: tuple[str, int]) -> np.ndarray:
    """Averaging times up to 1000 s that all of these recordings reach; `Missing` without any."""
    taus = ALL_S
    for key in keys:
        while taus.size:
            try:
                study.adev(key, "L", taus)
                break
            except KeyError:
                taus = taus[:-1]
    if taus.size < 3:
        raise Missing(keys)
    return taus


def _distance_above(study: Study) -> Finding:
    above = [
        bool(np.all(study.adev(key, "L", SHORT_S) > study.adev(key, s, SHORT_S)))
        for key in subsets()
        for s in ("x1", "x2")
    ]
    return by_count(f"{share(above)} curves below that of L", above, 0.9)


def _distance_below(study: Study) -> Finding:
    below = []
    for key in subsets():
        taus = _reaches(study, key)
        taus = taus[taus >= 1.0]
        most = np.maximum(study.adev(key, "x1", taus), study.adev(key, "x2", taus))
        below += (study.adev(key, "L", taus) <= 1.1 * most).tolist()
    return by_count(share(below), below, 0.9)


def _slopes(study: Study) -> Finding:
    """Local slopes over a third of a decade, of every subset and series."""
    found = dict.fromkeys(SLOPES, 0)
    curves = 0
    for key in subsets():
        taus = _reaches(study, key)
        step = np.log(taus[1] / taus[0]) * 2
        for series in SERIES:
            level = np.log(study.adev(key, series, taus))
            local = (level[2:] - level[:-2]) / step
            curves += 1
            for slope in SLOPES:
                found[slope] += bool(np.any(np.abs(local - slope) < 0.1))
    text = ", ".join(f"{slope:+g} in {count}" for slope, count in found.items())
    return decided(f"{text} of {curves} curves", all(found.values()))


def _random_walk(study: Study) -> Finding:
    """Share of AVAR at 1000 s of h_-2, and of what looks like it there: T_c of 1000 s and more."""
    shares, alike = [], []
    for key in subsets():
        for series in COORDINATES:
            model = model_of(study, key, series)
            m = np.array([1000.0 * 120])
            total = model.avar(m, 120, "continuous")[0]
            walk = sum(
                c.avar(m, 120, "continuous")[0]
                for c in model.components
                if getattr(c, "alpha", 0) == -2
            )
            slow = sum(
                c.avar(m, 120, "continuous")[0]
                for c in model.components
                if getattr(c, "T_c", 0) >= 1000
            )
            shares.append(walk / total > 0.1)
            alike.append((walk + slow) / total > 0.1)
    text = f"h_-2 in {share(shares)}; with correlated noise of 1000 s and more {share(alike)}"
    return by_count(text, shares, 0.5)


def _ratio(study: Study, first: str, second: str, series: str) -> np.ndarray:
    keys = whole(first), whole(second)
    taus = _reaches(study, *keys)
    ratio: np.ndarray = study.adev(keys[0], series, taus) / study.adev(keys[1], series, taus)
    return ratio


def _noisier(first: str, second: str, least: float) -> Callable[[Study], Finding]:
    """ADEV of L and x1 of one type over another's: above 1 at all tau, `least` in the median."""

    def find(study: Study) -> Finding:
        ratios = {s: _ratio(study, first, second, s) for s in ("L", "x1")}
        text = "; ".join(
            f"{s}: {np.median(r):.1f} times ({r.min():.2f} to {r.max():.1f})"
            for s, r in ratios.items()
        )
        good = all(r.min() > 1 and np.median(r) > least for r in ratios.values())
        return decided(text, good)

    return find


def _tenth_camera(study: Study) -> Finding:
    ratios = _ten_over_nine(study)
    text = ", ".join(f"{s}: {r:.2f} times" for s, r in ratios.items())
    return decided(text, all(r > 1 for r in ratios.values()))


def _intermediate(study: Study) -> Finding:
    ratios = _ten_over_nine(study)
    low, high = sorted((ratios["x1"], ratios["x2"]))
    text = ", ".join(f"{s}: {r:.2f}" for s, r in ratios.items())
    return decided(text, low < ratios["L"] < high)


def _ten_over_nine(study: Study) -> dict[str, float]:
    taus = np.geomspace(0.01, 1.0, 9)
    return {
        s: float(
            np.exp(
                np.mean(
                    np.log(
                        study.adev(("Vantage", 10), s, taus) / study.adev(("Vantage", 9), s, taus)
                    )
                )
            )
        )
        for s in ("x1", "x2", "L")
    }


def _sigma_c(study: Study) -> Finding:
    keys = (*map(whole, TYPES), ("All", 30))
    ratios = []
    for key in keys:
        row = study.gaussian(key)
        pair = "pair_sigma_L_mm" in row  # only along the line between the markers can they agree
        prefix = "pair_" if pair else ""
        ratios.append(row[f"{prefix}sigma_L_mm"] / row[f"{prefix}sigma_C_mm"])
    text = ", ".join(f"{k[0]} {r:.3f}" for k, r in zip(keys, ratios, strict=True))
    return decided(f"sigma_L/sigma_C: {text}", all(abs(r - 1) < 0.03 for r in ratios))


def _chi_squared(study: Study) -> Finding:
    try:
        p = [study.gaussian(key)["pair_chi2_p"] for key in subsets()]
    except KeyError:
        return unknown("S does not include the tests")
    from scipy.stats import kstest

    known = [v for v in p if np.isfinite(v)]
    if len(known) < 5:
        return unknown("too few tests")
    uniform = float(kstest(known, "uniform").pvalue)
    text = f"p > 0.05 in {share([v > 0.05 for v in known])}; p of uniform p {uniform:.2g}"
    return decided(text, uniform > 0.01)


def _bonita_large(study: Study) -> Finding:
    rows = {kind: study.gaussian(whole(kind)) for kind in TYPES}
    ratio = min(
        rows["Bonita"][f"sigma_{k}_mm"] / rows[kind][f"sigma_{k}_mm"]
        for k in (1, 2)
        for kind in ("T40", "Vantage")
    )
    rho = rows["Bonita"]["rho_12"]
    text = f"at least {ratio:.2f} times the others' sigma; rho {rho:.2f}"
    return decided(text, ratio > 1 and abs(rho) < 0.3)


def _t40_correlated(study: Study) -> Finding:
    rows = {kind: study.gaussian(whole(kind)) for kind in TYPES}
    rho = rows["T40"]["rho_12"]
    largest = max(rows["T40"]["sigma_1_mm"], rows["T40"]["sigma_2_mm"])
    smallest = min(rows[k][f"sigma_{i}_mm"] for k in ("Bonita", "Vantage") for i in (1, 2))
    text = f"sigma at most {largest:.4f} mm, others' at least {smallest:.4f} mm; rho {rho:.2f}"
    return decided(text, rho > 0.5 and largest < smallest)


HISTORY = "a twin has the published spectra but not the published history, which determines sigma"
CLAIMS: Sequence[Claim[Study]] = (
    Claim(
        "S-3.5-tenth",
        "3.5",
        "noise is larger with 10 Vantage cameras, one of them failing, than with 9 (Figure 8)",
        "ADEV with 10 over ADEV with 9, 0.01 to 1 s, geometric mean",
        "above 1 in x1, x2 and L",
        _tenth_camera,
    ),
    Claim(
        "S-3.5-extents",
        "3.5",
        "the markers are affected to different extents, the distance to an intermediate one",
        "the same ratios",
        "that of L between those of x1 and x2",
        _intermediate,
    ),
    Claim(
        "S-4.2-sigma-C",
        "4.2",
        "the distance scatters as correlated Gaussian errors of the markers imply (sigma_C)",
        "sigma_L / sigma_C of T40, Bonita, Vantage and all",
        "within 3 % of 1",
        _sigma_c,
    ),
    Claim(
        "S-4.2-chi-squared",
        "4.2",
        "chi-squared tests confirm that L comes from a Gaussian distribution with sigma_C",
        "p of the test of L against Gaussian noise of the same spectrum, all subsets",
        "uniformly distributed (Kolmogorov-Smirnov p > 0.01), as by chance alone",
        _chi_squared,
    ),
    Claim(
        "S-4.2-Bonita",
        "4.2",
        "Bonita: variance relatively large, the markers hardly correlated",
        "sigma over that of T40 and Vantage; rho_12",
        "above 1; below 0.3",
        _bonita_large,
        HISTORY,
        by_chance=True,
    ),
    Claim(
        "S-4.2-T40",
        "4.2",
        "T40: variance small, the markers highly correlated",
        "largest sigma beside the others' smallest; rho_12",
        "smaller; above 0.5",
        _t40_correlated,
        HISTORY,
        by_chance=True,
    ),
    Claim(
        "S-4.3-distance-short",
        "4.3",
        "from 0.01 to 0.1 s ADEV of L exceeds those of x1 and x2",
        "curves of x1 and x2, over all subsets, wholly below that of L",
        "nine in ten",
        _distance_above,
    ),
    Claim(
        "S-4.3-distance-long",
        "4.3",
        "at longer times ADEV of L is on a par with those of x1 and x2 or smaller",
        "share of subsets and tau from 1 s on with ADEV(L) at most 1.1 times the larger of both",
        "nine in ten",
        _distance_below,
    ),
    Claim(
        "S-4.3-slopes",
        "4.3",
        "slopes -1, -1/2, 0 and 1/2 can all be observed",
        "curves, of all subsets and series, with a local slope within 0.1 of each",
        "each in one at least",
        _slopes,
    ),
    Claim(
        "S-4.3-walk",
        "4.3",
        "random walk is present",
        "series of coordinates in which h_-2 makes a tenth of AVAR at 1000 s",
        "half of them",
        _random_walk,
        "random walk and slow correlated noise have one shape below T_c",
    ),
    Claim(
        "S-4.4-Bonita",
        "4.4",
        "Bonita has much higher ADEV than the two other types (Figure 13)",
        "ADEV of L and x1 over those of Vantage, 0.01 to 1000 s, most cameras",
        "above 1 everywhere, above 1.5 in the median",
        _noisier("Bonita", "Vantage", 1.5),
    ),
    Claim(
        "S-4.4-Vantage",
        "4.4",
        "Vantage is noisier than the older T40 (Figure 13)",
        "ADEV of L and x1 over those of T40, 0.01 to 1000 s, most cameras",
        "above 1 everywhere",
        _noisier("Vantage", "T40", 1.0),
    ),
)


REPEATS = 200
SURE = 0.95
ENOUGH = 0.5  # share of realisations that must decide
SLOW_SAMPLES = 1 << 12  # every eight seconds of nine hours: moments need no more


def draw(
    twins: Mapping[Key, Twin], cleaning: Cleaning | None = None, repeats: int = REPEATS
) -> list[Drawn]:
    """`repeats` realisations of the moments of all twins, as the outlier filter leaves them."""
    found = {
        key: realisations(twin, repeats, cleaning, SLOW_SAMPLES) for key, twin in twins.items()
    }
    return [
        Drawn({key: {name: float(v[k]) for name, v in of.items()} for key, of in found.items()})
        for k in range(repeats if found else 0)
    ]


def of_realisations(
    claim: Claim[Study], found: Finding, draws: Sequence[Drawn]
) -> tuple[Finding, str]:
    """The finding with the word that realisations give it, and in how many it holds.

    A realisation that is not precise enough decides nothing. Of those that decide the claim holds
    in 95 % and more (it holds) or in 5 % and fewer (it does not); between them, and where fewer
    than half decide, one recording cannot tell. As found, and no count, where the claim is not by
    chance, or not all of its recordings are twins.
    """
    if not claim.by_chance or not draws:
        return found, ""
    each = [_finding(claim, one) for one in draws]
    if not all(one.there for one in each):
        return found, ""
    words = [one.word for one in each]
    holds, decided = words.count(HOLDS), len(words) - words.count(UNKNOWN)
    word = UNKNOWN
    if decided >= ENOUGH * len(draws):
        if holds >= SURE * decided:
            word = HOLDS
        elif holds <= (1 - SURE) * decided:
            word = DOES_NOT
    counted = f"holds in {holds} of {decided}"
    if decided < len(draws):
        counted += f" that decide, {len(draws)} drawn"
    return Finding(found.value, word), counted


def _finding(claim: Claim[Study], one: Drawn) -> Finding:
    try:
        return claim.find(one)  # type: ignore[arg-type]  # claims by chance ask for moments alone
    except KeyError:
        return unknown("not drawn", there=False)
