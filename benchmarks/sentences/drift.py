"""Straight drift and warm-ups under noise, by `likelihood`: detection, intervals, and false
detection in random walks, flicker noise and slow correlation.

"holds": the 95 % interval, or the 95 % limit of what was not detected, includes the truth.
Recordings of 10 or 15 min at 100 or 120 Hz with white noise of 0.05 mm and the named component:
drift of 0.1 to 0.3 mm in 10 min, warm-ups of 0.05 to 0.5 mm, of either sign. At 8b8d0af these
parameters did not exist; its h_-2 and detections come from the same recordings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from benchmarks.sentences import Row, percent
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw
from mocap_metrology.noise.model.synthesis import Cross, draw_pair

WHITE = PowerLaw(0, 5e-5)
NOISES = {
    "white": NoiseModel((WHITE,)),
    "white + flicker": NoiseModel((WHITE, PowerLaw(-1, 1.5e-5))),
    "white + random walk": NoiseModel((WHITE, PowerLaw(-2, 5e-7))),
    "white + Gauss-Markov 1 s": NoiseModel((WHITE, GaussMarkov(0.04, 1.0))),
}
SLOW = {
    "white + weak random walk": NoiseModel((WHITE, PowerLaw(-2, 2e-8))),
    "white + Gauss-Markov 30 s": NoiseModel((WHITE, GaussMarkov(0.012, 30.0))),
    "white + Gauss-Markov 300 s": NoiseModel((WHITE, GaussMarkov(0.004, 300.0))),
}
NAMES = ("h_-2", "drift", "A_w", "T_w")
LENGTHS = ((60_000, 100.0), (72_000, 120.0), (90_000, 100.0), (108_000, 120.0))
NINE_HOURS = ((3_240_000, 0.01),)


def straight(rng: np.random.Generator) -> dict[str, float]:
    """0.1 to 0.3 mm in 10 min."""
    return {"drift": rng.choice([-1, 1]) * rng.uniform(0.6, 1.8)}


def warm_up(T_w: float) -> Callable[[np.random.Generator], dict[str, float]]:
    """0.05 to 0.5 mm, evenly in its logarithm."""
    return lambda rng: {
        "A_w": rng.choice([-1, 1]) * float(np.exp(rng.uniform(np.log(0.05), np.log(0.5)))),
        "T_w": T_w,
    }


def series_of(
    model: NoiseModel,
    part: dict[str, float],
    n: int,
    frame_rate_hz: float,
    rng: np.random.Generator,
) -> np.ndarray:
    """(n,) mm."""
    tau0 = 1 / frame_rate_hz
    noise = draw_pair(model, model, Cross(constant=0.0), n, frame_rate_hz, rng)[0]
    t = np.arange(n) * tau0
    wave = part.get("drift", 0.0) / 3600 * t
    return noise + wave + part.get("A_w", 0.0) * np.exp(-t / part.get("T_w", 1.0))


def holds(c: object, truth: float) -> bool:
    """Whether interval or limit holds the truth; a limit is of the size."""
    if not c.detected:
        return not np.isfinite(c.upper_95) or abs(truth) <= c.upper_95 * (1 + 1e-9)
    return c.lower_95 <= truth <= c.upper_95


def study(
    model: NoiseModel, part_of: Callable, n: int, seed: int, lengths: tuple = LENGTHS
) -> dict[str, list]:
    """name -> (detected, holds, width of the 95 % interval over that of the bound) a recording."""
    found: dict[str, list] = {name: [] for name in NAMES}
    for k in range(n):
        rng = np.random.default_rng([seed, k])
        size, rate = lengths[k % len(lengths)]
        part = part_of(rng)
        truth = {**part, "h_-2": next((c.h for c in model.components if is_walk(c)), 0.0)}
        rows = likelihood(series_of(model, part, size, rate, rng), rate).estimate.coefficients
        for c in rows:
            if c.parameter in NAMES:
                wide = (c.upper_95 - c.lower_95) / (2 * 1.96 * c.crlb) if c.detected else np.nan
                held = holds(c, truth.get(c.parameter, 0.0))
                found[c.parameter].append((c.detected, held, wide))
    return found


def is_walk(c: object) -> bool:
    """Whether a component is the random walk."""
    return isinstance(c, PowerLaw) and c.alpha == -2


def rows(n: int) -> Iterator[Row]:
    """n recordings a case, n / 5 of nine hours."""
    parts = {
        "straight drift": (straight, ("drift",)),
        "warm-up 60 s": (warm_up(60.0), ("A_w", "T_w")),
        "warm-up 300 s": (warm_up(300.0), ("A_w", "T_w")),
    }
    for i, (noise, model) in enumerate(NOISES.items()):
        for j, (name, (part_of, own)) in enumerate(parts.items()):
            yield from _case(f"{noise}, {name}", study(model, part_of, n, 100 * i + j), own, n)
    for i, (noise, model) in enumerate((NOISES | SLOW).items()):
        found = study(model, lambda rng: {}, n, 1000 + i)
        yield from _without(noise, found, n, any(map(is_walk, model.components)))
    few = max(n // 5, 2)
    walk = NOISES["white + random walk"]
    for name, part_of, own in (
        ("nine hours, warm-up 300 s", warm_up(300.0), ("A_w", "T_w")),
        ("nine hours, none", lambda rng: {}, ()),
    ):
        found = study(walk, part_of, few, 2000, NINE_HOURS)
        yield from _case(name, found, own, few) if own else _without(name, found, few, True)


def _case(case: str, found: dict[str, list], own: tuple[str, ...], n: int) -> Iterator[Row]:
    for name in NAMES:
        if found[name]:
            yield case, f"{name} holds", n, ">= 90 %", percent(h for _, h, _ in found[name])
    for name in own:
        if found[name]:
            yield case, f"{name} found", n, "", percent(d for d, _, _ in found[name])
            wide = [w for d, _, w in found[name] if d]
            if wide:
                yield case, f"{name} width/bound", n, "<= 1.5", f"{np.median(wide):.2f}"


def _without(noise: str, found: dict[str, list], n: int, walks: bool) -> Iterator[Row]:
    case = f"{noise}, no drift"
    both = zip(found["drift"], found["A_w"], strict=True)
    yield case, "drift or warm-up found", n, "<= 5 %", percent(a[0] or b[0] for a, b in both)
    held = percent(h for _, h, _ in found["h_-2"])
    yield case, "h_-2 holds", n, ">= 90 %" if walks else "", held
    yield case, "h_-2 found", n, "", percent(d for d, _, _ in found["h_-2"])
