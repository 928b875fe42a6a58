"""The kinds of `labs`: two markers, 5 min at 50 Hz or as the kind has it."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy import ndimage, signal

from benchmarks.sentences import _makers as of
from benchmarks.sentences import _waves as w
from benchmarks.sentences._kinds import coloured, walk
from benchmarks.sentences.unforeseen import SLOW

kind = partial(w.kind, rate=50.0, seconds=300.0)
in_x1 = partial(w.in_x1, rate=50.0, seconds=300.0)
LOUD = "event heavy_tails level_changes"  # that the noise changes in time, in any form
SWING = w.after(40, 150, lambda r, s: w.ringing(s, 0.5, 25, 0.8))

KINDS: dict[str, w.Kind] = {
    "exposure that hunts": kind(w.louder(w.dwelling(2, 6, [0.8, 1.0, 1.25])), "", LOUD),
    "volatile noise": kind(
        w.louder(lambda r, t: np.exp(0.4 * w.ou(r, t, 2.0))), "heavy_tails", "level_changes"
    ),
    "noise that swings": kind(
        w.louder(lambda r, t: 1 + 0.5 * np.sin(2 * np.pi * (t / 10 + r.uniform()))),
        "heavy_tails",
        "level_changes",
    ),
    "building site": in_x1(of.building, "", f"{LOUD} resonance"),
    "lost every 7 s": kind(w.lost(lambda r, t: (t + r.uniform(0, 7)) % 7 < 1.5), good=False),
    "frames of both stall": kind(
        w.lost(w.pulses(lambda r: np.cumsum(r.uniform(20, 90, 20)), lambda s: s < 3), 2)
    ),
    "images merge": kind(of.merging, "event", "heavy_tails moves"),
    "ghosts": kind(of.ghosts, "", "event heavy_tails moves"),
    "reflections": kind(of.reflections, "", "event heavy_tails"),
    "vibration, jittery clock": in_x1(
        lambda r, t: 0.03 * np.sin(2 * np.pi * 9.3 * (t + 3e-3 * r.standard_normal(t.size))), "line"
    ),
    "vibration, frames dropped": in_x1(of.dropped, "", "line"),
    "steps of 0.1 mm": kind(of.rounded(0.1), "resolution_limited", placed=False),
    "steps of 0.1 mm and drift": kind(
        of.rounded(0.1, 0.4), "resolution_limited", "drift wander", placed=False
    ),
    "steps of 1 mm": kind(of.rounded(1.0), "", "resolution_limited", placed=False, good=False),
    "half floats": kind(of.half_floats, "", "resolution_limited", placed=False),
    "unit changes": kind(
        of.other_unit, "step moves", "event resolution_limited", placed=False, good=False
    ),
    "in m": kind(lambda r, t, x: w.placed(x) / 1000, unit="m", placed=False),
    "straight fills": kind(of.filled_linearly, "gap_filled", "heavy_tails"),
    "Butterworth 1.5 Hz": kind(of.filtered(2, 1.5), "low_pass"),
    "Butterworth 22 Hz of 25": kind(of.filtered(4, 22.0), "", "low_pass smoothed"),
    "one pass at 8 Hz": kind(of.filtered(2, 8.0, both=False), "low_pass"),
    "Bessel-like, first order at 10 Hz": kind(
        of.filtered(1, 10.0, both=False), "", "low_pass smoothed"
    ),
    "high pass": kind(of.filtered(1, 0.05, both=False, kind="high")),
    "notch": kind(lambda r, t, x: signal.filtfilt(*signal.iirnotch(12.5, 5, fs=50), x)),
    "exponential, light": kind(
        lambda r, t, x: signal.lfilter([0.8], [1, -0.2], x), "", "low_pass smoothed"
    ),
    "exponential, heavy": kind(
        lambda r, t, x: signal.lfilter([0.1], [1, -0.9], x), "smoothed low_pass"
    ),
    "dead band": kind(of.dead_band, "", "repeated running_median heavy_tails"),
    "nearest of 45 Hz": kind(
        lambda r, t, x: x[:, np.floor(t * 45.0 + 0.3).astype(int) % t.size],
        "repeated resampled",
        "heavy_tails",
    ),
    "every second interpolated": kind(of.doubled, "resampled low_pass", "heavy_tails"),
    "a part is copied": kind(of.copied),
    "cable that swings": in_x1(SWING, "event line", f"{LOUD} moves"),
    "leaning on the table": in_x1(w.after(50, 150, of.leaning), "shift wander event", "moves"),
    "leaning, again and again": in_x1(of.leanings, "wander levels", "event moves"),
    "shade": in_x1(lambda r, t: 0.03 * np.tanh(1.2 * w.ou(r, t, 15.0)), "", "wander"),
    # Stretches in the sun, each warming and cooling with 12 s
    "clouds": in_x1(
        lambda r, t: 0.08 * w.lagging(w.dwelling(10, 70, [1.0, 0.0], 40)(r, t), t, 12),
        "wander",
        "event",
    ),
    "pump that drifts": in_x1(
        lambda r, t: 0.03 * w.swept(t, r.uniform(0.3, 1.5) + 0.06 * w.ou(r, t, 30.0)), "", "line"
    ),
    "two pumps": in_x1(of.two_pumps, "line", LOUD),
    "passers-by": in_x1(of.passers_by, "event", f"{LOUD} line"),
    "calibrated anew": kind(of.recalibrated, "step", "event moves", placed=False, good=False),
    "camera lost": kind(of.camera_lost, "step event level_changes", "moves"),
    "thermostat": in_x1(of.thermostat, "cycle wander", "line"),
    "two time constants": in_x1(
        w.summed(w.decay(0.2, 12), w.decay(0.2, 150)), f"{SLOW} warm_up", "moves"
    ),
    "slips, ever rarer": in_x1(of.slips, "wander step", "event moves"),
    "warm for a while": in_x1(of.warm_for_a_while, "wander", "moves"),
    "drift over pixels": in_x1(
        lambda r, t: t / t[-1] + 0.03 * np.sin(2 * np.pi * t / t[-1] / 0.21),
        "drift wander",
        "cycle line moves",
        good=False,
    ),
    "heating switched on": in_x1(
        w.after(80, 160, lambda r, s: -0.15 * np.expm1(-s / 40)), "wander", "moves"
    ),
    "peels and falls": in_x1(of.peeling, "step moves event", "accelerating wander", good=False),
    # An elevator's weight on two floors, ten seconds between them
    "lift": in_x1(
        lambda r, t: ndimage.uniform_filter1d(w.dwelling(25, 60, [0.0, 0.06])(r, t), 500),
        "wander two_levels levels",
        "event",
    ),
    "sag that rings": in_x1(
        w.after(80, 220, lambda r, s: 0.3 * (1 - np.exp(-s / 1.5) * np.cos(2 * np.pi * 1.7 * s))),
        "step event",
        "moves heavy_tails",
    ),
    "person": kind(w.common(of.person), "", "moves event wander line", good=False),
    "walk between walls": kind(of.bouncing, "", "wander"),
    "correlated over 100 s": kind(of.mixed((100.0, 0.04)), "", "wander random_walk"),
    "correlated over 1 and 30 s": kind(of.mixed((1.0, 0.02), (30.0, 0.03)), "", "wander"),
    "flicker": kind(w.of_noise(coloured(-1.0, w.WHITE / 2), 1.0), "", "wander"),
    "walk": kind(w.of_noise(walk(5e-4), 1.0), "", "wander random_walk"),
    "lamps": in_x1(of.lamps, "line", rate=60.0),
    "cameras in turn": kind(lambda r, t, x: x + 0.006 * (-1.0) ** np.arange(t.size), "", "line"),
    "3 s": kind(lambda r, t, x: x, seconds=3.0, good=False),
    "30 s at 1000 Hz": kind(lambda r, t, x: x, seconds=30.0, rate=1000.0),
    "one marker": kind(lambda r, t, x: x, markers=1, good=False),
    "twelve markers": kind(lambda r, t, x: x, markers=12, seconds=120.0),
    "lost at each blade": kind(w.lost(lambda r, t: np.arange(t.size) % 13 < 2), good=False),
    "both lost every 3 s": kind(
        w.lost(lambda r, t: (t + r.uniform(0, 3)) % 3 < 0.5, 2), good=False
    ),
    "filtered, with a line": kind(
        w.then(w.added(0, w.sine(0.03, 3.1)), of.filtered(2, 6.0)), "low_pass", "line"
    ),
    "gain as a saw": kind(
        w.louder(lambda r, t: 0.7 + 0.6 * ((t / 20 + r.uniform()) % 1)), "", f"{LOUD} recurring"
    ),
    "swings twice": in_x1(
        lambda r, t: SWING(r, t) + 0.6 * SWING(r, t), "event line", f"{LOUD} moves"
    ),
    "creep and step": in_x1(
        lambda r, t: 0.05 * np.log1p(t / 8) + 0.08 * (t > r.uniform(100, 250)),
        "step wander creep",
        "event moves slowing warm_up",
    ),
    "warm-up and pause": kind(
        w.then(w.added(0, w.decay(0.25, 80)), w.lost(lambda r, t: (t > 120) & (t < 180), 2)),
        "warm_up wander slowing",
        "moves",
    ),
    "settling": in_x1(
        lambda r, t: 0.12 * np.exp(-t / 90) * np.sin(2 * np.pi * t / 47 + r.uniform(0, 6)),
        "wander cycle",
        "line moves",
    ),
    "frame walks": kind(  # the frame of the cameras, so all markers alike
        w.common(lambda r, t: np.cumsum(4e-4 * r.standard_normal((3, t.size)), axis=1)),
        "wander random_walk",
    ),
    "spins up": in_x1(
        lambda r, t: 0.03 * w.swept(t, np.minimum(4 + 12 * t / 60, 16.0)), "line", LOUD
    ),
    "line at the end": in_x1(
        lambda r, t: 0.04 * (t > 200) * np.sin(2 * np.pi * 11.3 * t), "line", LOUD
    ),
    "saw-tooth line": in_x1(
        lambda r, t: 0.03 * signal.sawtooth(2 * np.pi * 3.07 * t), "line", "heavy_tails"
    ),
    "heart": in_x1(
        w.bells(lambda r: np.cumsum(r.normal(0.9, 0.04, 400)), 0.05, 0.05),
        "line recurring",
        "heavy_tails",
    ),
    "drafts": in_x1(
        w.pulses(
            lambda r: np.cumsum(r.normal(60, 10, 8)), lambda s: 0.08 * s / 5 * np.exp(1 - s / 5)
        ),
        "wander",
        "event moves recurring cycle",
    ),
    "level flickers": kind(
        w.louder(lambda r, t: np.exp(0.3 * coloured(-1.0, 1.0)(r, t.size, 50.0) / 3)),
        "",
        "heavy_tails level_changes",
    ),
    "shadows": kind(w.louder(of.shadows), "", LOUD),
    "salt": kind(
        lambda r, t, x: x + (r.random(x.shape) < 0.01) * r.normal(0, 1, x.shape), "", "heavy_tails"
    ),
    "one-sided tails": kind(
        lambda r, t, x: x + (r.random(x.shape) < 0.02) * r.exponential(0.1, x.shape),
        "",
        "heavy_tails",
    ),
    "stairs": in_x1(
        lambda r, t: 0.01 * np.floor(t / 10), "", "drift wander step levels moves cycle line"
    ),
    "triangle wave": in_x1(
        lambda r, t: 0.05 * signal.sawtooth(2 * np.pi * t / 60, 0.5), "cycle wander", "line"
    ),
    "cycle with jumps": in_x1(of.unsteady, "wander", "line cycle event"),
    "packets lost": kind(  # each tenth frame repeats the one before
        lambda r, t, x: x[:, np.arange(t.size) - (np.arange(t.size) % 10 == 9)],
        "repeated",
        "heavy_tails",
    ),
    "cubic from 43 Hz": kind(of.cubic, "resampled", "heavy_tails low_pass"),
    # By a Kalman filter of constant position
    "smoothed both ways": kind(
        lambda r, t, x: signal.filtfilt([0.2], [1, -0.8], x), "low_pass smoothed"
    ),
    "median and mean": kind(
        lambda r, t, x: ndimage.uniform_filter1d(ndimage.median_filter(x, (1, 3)), 3, axis=1),
        "low_pass",
        "running_median heavy_tails",
    ),
    "one coordinate filtered": kind(of.one_coordinate, "", "low_pass"),
    "labels exchanged for good": kind(of.for_good, "exchanged step", "event moves", placed=False),
    "appears late": kind(w.lost(lambda r, t: t < 150), good=False),
    # One that rolls by: the floor bends and comes back
    "cart": in_x1(
        w.bells(lambda r: np.cumsum(r.uniform(40, 120, 6)), 0.1, 6), "wander event", "moves"
    ),
    "three takes": kind(  # each with a place of its own
        lambda r, t, x: x + r.normal(0, 0.05, (6, 3))[:, np.minimum((t / 100).astype(int), 2)],
        "step event wander",
        "moves shift levels",
    ),
    "1 Hz for 2 h": kind(lambda r, t, x: x, rate=1.0, seconds=7200.0),
    "0.5 um": kind(lambda r, t, x: x / 40),
    "constant": kind(lambda r, t, x: 0 * x, "", "resolution_limited", good=False),
    "projector": in_x1(
        lambda r, t: 0.03 * (1 + 0.8 * np.sin(2 * np.pi * 0.2 * t)) * np.sin(2 * np.pi * 17.4 * t),
        "line",
        LOUD,
    ),
    "heater": in_x1(  # five seconds of heat every 70 s, which fades in 20 s
        lambda r, t: 0.3 * w.lagging(((t + 30) % 70 < 5).astype(float), t, 20),
        "cycle wander",
        "line recurring event moves",
    ),
    "shifts that recover": kind(
        w.added(4, *(of.faded(at) for at in (60, 140, 230))), "wander shift event step", "moves"
    ),
    "five digits": kind(of.five_digits, "resolution_limited", "heavy_tails", placed=False),
    "hundredths of cm": kind(
        lambda r, t, x: np.round(w.placed(x) / 10, 2) * 10, "resolution_limited", placed=False
    ),
    # One frame is off every 10 s
    "ticks": in_x1(
        lambda r, t: 0.5 * (np.arange(t.size) % 500 == 250), "", "heavy_tails recurring line"
    ),
    "antiphase": kind(w.along([0, 1, 0, 0, -1, 0], w.sine(0.04, 5.5)), "line"),
    "edges of gaps": kind(of.edges_of_gaps, "", "event heavy_tails", good=False),
    "cut off": kind(lambda r, t, x: np.clip(x, -0.03, 0.03)),
    "common wander": kind(
        w.common(lambda r, t: 0.015 * np.array([w.ou(r, t, 8.0) for _ in range(3)])), "", "wander"
    ),
    "blue": kind(lambda r, t, x: np.diff(np.hstack([x, x[:, :1]]), axis=1) * 0.7 + 0.3 * x),
    "axes unlike": kind(lambda r, t, x: x * np.resize([1, 5, 0.2], (6, 1))),
    "overshoot": in_x1(w.summed(w.decay(0.3, 90), w.decay(-0.3, 25)), "wander warm_up", "moves"),
    "drift and gap": kind(
        w.then(
            lambda r, t, x: x + np.linspace(0, 0.2, t.size),
            w.lost(lambda r, t: (t > 100) & (t < 140)),
        ),
        "drift wander",
    ),
    "louder late": kind(
        w.louder(lambda r, t: 1 + 0.8 * np.expm1(t / t[-1] * 2) / np.expm1(2)),
        "level_changes",
        "event heavy_tails",
    ),
    "outliers replaced": kind(of.outliers_replaced, "", "heavy_tails running_median repeated"),
    "two doors": in_x1(
        lambda r, t: w.ringing(t % 19, 0.12, 0.4, 5) + w.ringing((t + 5) % 31, 0.1, 0.5, 3.3),
        "event recurring",
        f"line {LOUD}",
    ),
    # Linear, and stops
    "tripod sinks": in_x1(lambda r, t: 0.15 * np.clip((t - 60) / 120, 0, 1), "wander", "moves"),
    "gusts": in_x1(of.gusts, "", f"resonance {LOUD}"),
    "line, clock of heavy tails": in_x1(
        lambda r, t: 0.05 * np.sin(2 * np.pi * 3.1 * (t + 2e-3 * r.standard_t(2.2, t.size))),
        "line",
        "heavy_tails",
    ),
    "slides, and rests between": in_x1(w.sliding(25, 50, [0.0, 0.003]), "wander", "moves drift"),
    # All markers shift; half of it fades
    "kicked": kind(
        w.along([1.0, 0.5, -0.3], w.after(90, 210, lambda r, s: 0.1 + 0.1 * np.exp(-s / 20))),
        "step event wander",
        "moves",
    ),
    "loud for a minute": kind(of.loud_for_a_minute, "event level_changes", LOUD),
    "steeper than a walk": kind(w.of_noise(coloured(-3.0, w.WHITE / 2e3), 1.0), "", "wander"),
    "Savitzky-Golay of 51": kind(lambda r, t, x: signal.savgol_filter(x, 51, 3), "low_pass"),
    "wavelet": kind(of.wavelet, "repeated", "heavy_tails"),
    "coordinates held": kind(of.held_alone, "repeated", "heavy_tails"),
    "warm-up, step and line": in_x1(
        w.summed(w.decay(0.2, 80), w.step(0.1, 120, 250), w.sine(0.03, 6.3)),
        "step line",
        f"{SLOW} warm_up event",
    ),
    "clicks that fade": in_x1(
        w.pulses(lambda r: np.cumsum(r.exponential(25, 30)), lambda s: 0.12 * np.exp(-s / 3)),
        "event wander",
        LOUD,
    ),
    "day with doors": in_x1(
        of.day_with_doors, "wander", "event moves", rate=1.0, seconds=86400.0, good=False
    ),
    "fan as a square wave": in_x1(
        lambda r, t: 0.04 * signal.square(2 * np.pi * 0.31 * t), "line", "heavy_tails"
    ),
    "step and mains in a minute": in_x1(
        lambda r, t: 0.05 * (t > 31) + 0.02 * np.sin(2 * np.pi * 50 * t),
        "step line",
        "event moves",
        rate=500.0,
        seconds=60.0,
    ),
    "three frames off": kind(of.threes, "event", LOUD),
    "a little steeper than a walk": kind(
        w.of_noise(coloured(-2.5, w.WHITE / 100), 1.0), "", "wander"
    ),
}
