"""Codes of flashes from their lengths.

What is received lies anywhere in the 500 ticks below the longest flash of a code, and the analogue
front end adds up to 4 us to all flashes of a recording. Together that is more than one step, so a
length alone is ambiguous. But which rotor turns and which laser is off repeats each four cycles:
only the data bit is free, and its two lengths are two steps apart.
"""

from __future__ import annotations

import numpy as np

from mocap_metrology.lighthouse.timing import CODE_0_S, CODE_STEP_S

# Codes without data bit, of a master's four cycles; a slave has the laser on where the master's is
# off, and a station alone has it always on.
TIME_SHARING = np.array([4, 5, 0, 1])
ALONE = np.array([0, 1, 0, 1])
SKIP = 4
BIAS_STEPS = (-1.5, 0.5)  # 500 ticks below to 0 above, and 4 us to either side: -1.38 to 0.38
USUAL_BIAS_STEPS = -0.25
DECIDED_STEPS = 0.7  # from one of the two lengths of the data bit; halfway is 1


def steps_of(length_s: np.ndarray) -> np.ndarray:
    """Lengths in steps of 500 ticks above the longest flash of code 0."""
    return (length_s - CODE_0_S) / CODE_STEP_S


def find_pattern(
    cycle: list[np.ndarray], length_s: list[np.ndarray]
) -> tuple[list[np.ndarray], list[float]]:
    """Pattern (code without data bit by cycle modulo 4) and bias in seconds of each station.

    cycle, length_s: of the flashes of one station, or of master and slave. Every possible pattern
    is held against all flashes, with the bias that lets most of them agree.
    """
    names = [np.roll(TIME_SHARING, -turn) for turn in range(4)]
    if len(cycle) == 1:
        candidates = [[name] for name in [*names, ALONE, ALONE[[1, 0, 3, 2]]]]
    else:
        candidates = [[name, name ^ SKIP] for name in names]
    steps = [steps_of(length) for length in length_s]
    best: tuple[float, list[np.ndarray], list[float]] = (-np.inf, [], [])
    for patterns in candidates:
        fits = [
            _fit_bias(y - pattern[c % 4])
            for c, y, pattern in zip(cycle, steps, patterns, strict=True)
        ]
        score = sum(fit[0] for fit in fits)
        if score > best[0]:
            best = score, patterns, [fit[1] * CODE_STEP_S for fit in fits]
    return best[1], best[2]


def _fit_bias(above: np.ndarray) -> tuple[float, float]:
    """Share of agreement and bias: steps above the pattern are the bias, or the bias + 2."""
    above = np.sort(above)
    bias = np.arange(BIAS_STEPS[0], BIAS_STEPS[1], 0.02)

    def within(reach: float) -> np.ndarray:
        return sum(
            np.searchsorted(above, bias + data + reach)
            - np.searchsorted(above, bias + data - reach)
            for data in (0, 2)
        )

    score = (within(0.3) + within(0.1)) / (2 * max(above.size, 1))
    score = score - 0.01 * np.abs(bias - USUAL_BIAS_STEPS)  # decides where all bits are the same
    best = float(bias[np.argmax(score)])
    off = above - best
    off = off - 2 * (off > 1)
    near = off[np.abs(off) < 0.5]
    return float(score.max()), best + (float(np.median(near)) if near.size else 0.0)


def data_residual(cycle: np.ndarray, length_s: np.ndarray, pattern: np.ndarray) -> np.ndarray:
    """Steps between a length (bias taken off) and the nearer of the two of its data bit."""
    above = steps_of(length_s) - pattern[cycle % 4]
    return above - 2 * (above > 1)


def codes_of(cycle: np.ndarray, length_s: np.ndarray, pattern: np.ndarray) -> np.ndarray:
    """Codes, int8; -1 where the length is as near to neither data bit."""
    above = steps_of(length_s) - pattern[cycle % 4]
    code = pattern[cycle % 4] + 2 * (above > 1)
    decided = np.abs(data_residual(cycle, length_s, pattern)) <= DECIDED_STEPS
    return np.where(decided, code, -1).astype(np.int8)


def pattern_of(cycle: np.ndarray, code: np.ndarray) -> np.ndarray:
    """Code without data bit by cycle modulo 4, voted by the codes of a recording; -1: none seen."""
    pattern = np.full(4, -1)
    known = code >= 0
    for turn in range(4):
        votes = np.bincount(code[known & (cycle % 4 == turn)] & ~2, minlength=8)
        if votes.any():
            pattern[turn] = int(np.argmax(votes))
    return pattern
