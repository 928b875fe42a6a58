"""Recordings as laboratories make them, through files and all steps: what is said that is not so.

Two markers, 5 min at 50 Hz or as the kind has it, white noise of 0.02 mm a frame, in a C3D file.
`named`, `false`: as in `unforeseen`; a verdict `good` of a recording that is not is false too, and
so is a failure. Noise that is correlated over a third of a recording may be called a random walk.
"""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import signal

from benchmarks.sentences import _exports as export
from benchmarks.sentences import _labs as lab
from benchmarks.sentences._kinds import coloured, walk
from benchmarks.sentences.unforeseen import SLOW, WHITE, Make, Noise, in_x1, of_noise
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.recording.analyse import origin
from mocap_metrology.recording.clean import Entry, clean
from mocap_metrology.recording.noise import noise
from mocap_metrology.recording.verdict import diagnose, verdict
from mocap_metrology.settings import Settings

SETTINGS = Settings(noise={"estimators": ("likelihood",)}, second_opinion=False)
LOUD = "event heavy_tails level_changes"  # that the noise changes in time, in any form


@dataclass(frozen=True)
class Kind:
    """names, beside: as in `unforeseen`; good: whether its verdict may be; unit: of the file."""

    make: Make
    names: frozenset[str]
    beside: frozenset[str]
    rate: float = 50.0
    seconds: float = 300.0
    markers: int = 2
    good: bool = True
    unit: str = "mm"
    places: bool = True

    def drawn(self, rng: Noise) -> np.ndarray:
        """(3 markers, n) in units of the file."""
        t = np.arange(round(self.seconds * self.rate)) / self.rate
        x = WHITE * rng.standard_normal((3 * self.markers, t.size))
        return self.make(rng, t, x)


def kind(make: Make, names: str = "", beside: str = "", **how: float | bool | str) -> Kind:
    return Kind(make, frozenset(names.split()), frozenset(beside.split()), **how)


KINDS: dict[str, Kind] = {
    "exposure that hunts": kind(lab.louder(lab.hunting), "", LOUD),
    "volatile noise": kind(
        lab.louder(lambda r, t: np.exp(0.4 * lab.ou(r, t, 2.0))), "heavy_tails", "level_changes"
    ),
    "noise that swings": kind(
        lab.louder(lambda r, t: 1 + 0.5 * np.sin(2 * np.pi * (t / 10 + r.uniform()))),
        "heavy_tails",
        "level_changes",
    ),
    "building site": kind(in_x1(lab.building), "", f"{LOUD} resonance"),
    "lost every 7 s": kind(export.lost_regularly, good=False),
    "frames of both stall": kind(export.stalls),
    "images merge": kind(lab.merging, "event", "heavy_tails moves"),
    "ghosts": kind(lab.ghosts, "", "event heavy_tails moves"),
    "reflections": kind(lab.reflections, "", "event heavy_tails"),
    "vibration, jittery clock": kind(in_x1(lab.jittery_clock), "line"),
    "vibration, frames dropped": kind(export.dropped, "", "line"),
    "steps of 0.1 mm": kind(export.rounded(0.1), "resolution_limited", places=False),
    "steps of 0.1 mm and drift": kind(
        export.rounded(0.1, 0.4), "resolution_limited", "drift wander", places=False
    ),
    "steps of 1 mm": kind(export.rounded(1.0), "", "resolution_limited", places=False, good=False),
    "half floats": kind(export.half_floats, "", "resolution_limited", places=False),
    "unit changes": kind(
        export.other_unit, "step moves", "event resolution_limited", places=False, good=False
    ),
    "in m": kind(lambda r, t, x: export.placed(x) / 1000, unit="m", places=False),
    "straight fills": kind(export.filled_linearly, "gap_filled", "heavy_tails"),
    "Butterworth 1.5 Hz": kind(export.filtered(2, 1.5), "low_pass"),
    "Butterworth 22 Hz of 25": kind(export.filtered(4, 22.0), "", "low_pass smoothed"),
    "one pass at 8 Hz": kind(export.filtered(2, 8.0, both=False), "low_pass"),
    "Bessel-like, first order at 10 Hz": kind(
        export.filtered(1, 10.0, both=False), "", "low_pass smoothed"
    ),
    "high pass": kind(export.filtered(1, 0.05, both=False, kind="high")),
    "notch": kind(export.notch),
    "exponential, light": kind(export.exponential(0.8), "", "low_pass smoothed"),
    "exponential, heavy": kind(export.exponential(0.1), "smoothed low_pass", "low_pass"),
    "dead band": kind(export.dead_band, "", "repeated running_median heavy_tails"),
    "nearest of 45 Hz": kind(export.nearest(45.0), "repeated resampled", "heavy_tails"),
    "every second interpolated": kind(export.doubled, "resampled low_pass", "heavy_tails low_pass"),
    "a part is copied": kind(export.copied),
    "cable that swings": kind(in_x1(lab.swinging), "event line", f"{LOUD} moves"),
    "leaning on the table": kind(in_x1(lab.leaning), "shift wander event", "event moves"),
    "leaning, again and again": kind(in_x1(lab.leanings), "wander levels", "event moves"),
    "shade": kind(in_x1(lab.shaded), "", "wander"),
    "clouds": kind(in_x1(lab.clouds), "wander", "event"),
    "pump that drifts": kind(in_x1(lab.drifting_pump), "", "line"),
    "two pumps": kind(in_x1(lab.two_pumps), "line", LOUD),
    "passers-by": kind(in_x1(lab.passers_by), "event", f"{LOUD} line"),
    "calibrated anew": kind(export.recalibrated, "step", "event moves", places=False, good=False),
    "camera lost": kind(
        lab.camera_lost, "step event level_changes", "event level_changes moves step"
    ),
    "thermostat": kind(in_x1(lab.thermostat), "cycle wander", "line"),
    "two time constants": kind(in_x1(lab.two_constants), f"{SLOW} warm_up", "moves"),
    "slips, ever rarer": kind(in_x1(lab.slips), "wander step", "event moves"),
    "warm for a while": kind(in_x1(lab.held_warm), "wander", "moves"),
    "drift over pixels": kind(in_x1(lab.subpixel), "drift wander", "cycle line moves", good=False),
    "heating switched on": kind(in_x1(lab.switched_on), "wander", "moves"),
    "peels and falls": kind(
        in_x1(lab.peeling), "step moves event", "event moves accelerating wander", good=False
    ),
    "lift": kind(in_x1(lab.lift), "wander two_levels levels", "event"),
    "sag that rings": kind(in_x1(lab.sag), "step event", "event moves heavy_tails"),
    "person": kind(lab.person, "", "moves event wander line", good=False),
    "walk between walls": kind(lab.bouncing, "", "wander"),
    "correlated over 100 s": kind(lab.mixed((100.0, 0.04)), "", "wander random_walk"),
    "correlated over 1 and 30 s": kind(lab.mixed((1.0, 0.02), (30.0, 0.03)), "", "wander"),
    "flicker": kind(of_noise(coloured(-1.0, WHITE / 2), 1.0), "", "wander"),
    "walk": kind(of_noise(walk(5e-4), 1.0), "", "wander random_walk"),
    "lamps": kind(in_x1(lab.lamps), "line", rate=60.0),
    "cameras in turn": kind(export.alternate, "", "line"),
    "3 s": kind(lambda r, t, x: x, seconds=3.0, good=False),
    "30 s at 1000 Hz": kind(lambda r, t, x: x, seconds=30.0, rate=1000.0),
    "one marker": kind(lambda r, t, x: x, markers=1, good=False),
    "twelve markers": kind(lambda r, t, x: x, markers=12, seconds=120.0),
    "lost at each blade": kind(lab.fan_blades, good=False),
    "both lost every 3 s": kind(export.both_lost, good=False),
    "filtered, with a line": kind(export.filtered_with_line, "low_pass", "line"),
    "gain as a saw": kind(lab.louder(lab.sawtooth_gain), "", f"{LOUD} recurring"),
    "swings twice": kind(in_x1(lab.swings), "event line", f"{LOUD} moves"),
    "creep and step": kind(
        in_x1(lab.creep_and_step), "step wander creep", "event moves creep slowing warm_up"
    ),
    "warm-up and pause": kind(export.paused, "warm_up wander slowing", "moves"),
    "settling": kind(in_x1(lab.settling), "wander cycle", "line moves"),
    "frame walks": kind(lab.frame_walks, "wander random_walk"),
    "spins up": kind(in_x1(lab.spins_up), "line", f"{LOUD}"),
    "line at the end": kind(in_x1(lab.late_line), "line", f"{LOUD}"),
    "saw-tooth line": kind(in_x1(lab.saw_line), "line", "heavy_tails"),
    "heart": kind(in_x1(lab.heart), "line recurring", "heavy_tails"),
    "drafts": kind(in_x1(lab.drafts), "wander", "event moves recurring cycle"),
    "level flickers": kind(lab.louder(lab.flickering_level), "", "heavy_tails level_changes"),
    "shadows": kind(lab.louder(lab.shadows), "", LOUD),
    "salt": kind(lab.salt, "", "heavy_tails", good=True),
    "one-sided tails": kind(lab.one_sided, "", "heavy_tails"),
    "stairs": kind(in_x1(lab.stairs), "", "drift wander step levels moves cycle line"),
    "triangle wave": kind(
        in_x1(lambda r, t: 0.05 * signal.sawtooth(2 * np.pi * t / 60, 0.5)), "cycle wander", "line"
    ),
    "cycle with jumps": kind(in_x1(lab.unsteady), "wander", "line cycle event"),
    "packets lost": kind(export.packets, "repeated", "heavy_tails"),
    "cubic from 43 Hz": kind(export.cubic, "resampled", "heavy_tails low_pass"),
    "smoothed both ways": kind(export.kalman, "low_pass smoothed", "low_pass smoothed"),
    "median and mean": kind(export.two_filters, "low_pass", "running_median heavy_tails"),
    "one coordinate filtered": kind(export.one_coordinate, "", "low_pass"),
    "labels exchanged for good": kind(
        export.for_good, "exchanged step", "event moves", places=False
    ),
    "appears late": kind(export.late, good=False),
    "cart": kind(in_x1(lab.wheel), "wander event", "event moves"),
    "three takes": kind(export.breaks, "step event wander", "event moves shift levels"),
    "1 Hz for 2 h": kind(lambda r, t, x: x, rate=1.0, seconds=7200.0),
    "0.5 um": kind(lambda r, t, x: x / 40),
    "constant": kind(lambda r, t, x: 0 * x, "", "resolution_limited", good=False),
    "projector": kind(in_x1(lab.projector), "line", LOUD),
    "heater": kind(in_x1(lab.heater), "cycle wander", "line recurring event moves"),
    "shifts that recover": kind(
        lab.hanging_steps, "wander shift event step", "event moves shift step"
    ),
    "five digits": kind(export.five_digits, "resolution_limited", "heavy_tails", places=False),
    "hundredths of cm": kind(export.centimetres, "resolution_limited", "", places=False),
    "ticks": kind(export.ticks, "", "heavy_tails recurring line"),
    "antiphase": kind(lab.antiphase, "line"),
    "edges of gaps": kind(export.edges_of_gaps, "", "event heavy_tails", good=False),
    "cut off": kind(export.cut),
    "common wander": kind(lab.common, "", "wander"),
    "blue": kind(export.blue),
    "axes unlike": kind(export.axes),
    "overshoot": kind(in_x1(lab.overshoot), "wander warm_up", "moves"),
    "drift and gap": kind(export.drifted_gap, "drift wander", ""),
    "louder late": kind(lab.louder(lab.louder_late), "level_changes", "event heavy_tails"),
    "outliers replaced": kind(export.hampel_export, "", "heavy_tails running_median repeated"),
    "two doors": kind(in_x1(lab.two_doors), "event recurring", "line " + LOUD),
    "tripod sinks": kind(in_x1(lab.tilt), "wander", "moves"),
    "gusts": kind(in_x1(lab.gusts), "", "resonance " + LOUD),
    "line, clock of heavy tails": kind(in_x1(lab.wild_clock), "line", "heavy_tails"),
    "slides, and rests between": kind(in_x1(lab.slides), "wander", "moves drift"),
    "kicked": kind(lab.kicked, "step event wander", "event moves wander"),
    "loud for a minute": kind(lab.loud_minute, "event level_changes", LOUD),
    "steeper than a walk": kind(of_noise(coloured(-3.0, WHITE / 2e3), 1.0), "", "wander"),
    "Savitzky-Golay of 51": kind(export.of_51, "low_pass"),
    "wavelet": kind(export.wavelet, "repeated", "heavy_tails"),
    "coordinates held": kind(export.held_alone, "repeated", "heavy_tails"),
    "warm-up, step and line": kind(in_x1(lab.three_causes), "step line", f"{SLOW} warm_up event"),
    "clicks that fade": kind(in_x1(lab.clicks), "event wander", LOUD),
    "day with doors": kind(
        in_x1(lab.doors_of_a_day), "wander", "event moves", rate=1.0, seconds=86400.0, good=False
    ),
    "fan as a square wave": kind(
        in_x1(lambda r, t: 0.04 * signal.square(2 * np.pi * 0.31 * t)), "line", "heavy_tails"
    ),
    "step and mains in a minute": kind(
        in_x1(lambda r, t: 0.05 * (t > 31) + 0.02 * np.sin(2 * np.pi * 50 * t)),
        "step line",
        "event moves",
        rate=500.0,
        seconds=60.0,
    ),
    "three frames off": kind(lab.threes, "event", LOUD),
    "a little steeper than a walk": kind(of_noise(coloured(-2.5, WHITE / 100), 1.0), "", "wander"),
}


def told(one: Kind, values: np.ndarray, folder: Path) -> tuple[Counter[str], str]:
    """Findings and the word of the verdict of (3 markers, n) values in mm."""
    labels = [f"M{k + 1}" for k in range(one.markers)]
    frames = (export.placed(values) if one.places else values).reshape(one.markers, 3, -1)
    path = folder / "take.c3d"
    write_c3d(path, labels, one.rate, [frames.transpose(2, 0, 1)], frames.shape[2], one.unit)
    results = clean(Entry([str(path)], labels), origin("take"), SETTINGS, folder)
    noise(results, SETTINGS)
    found = diagnose(results, SETTINGS)
    word = verdict(results, {"recording": "take", "group": "check"}, SETTINGS)["word"]
    return Counter(one.code for one in found.findings), str(word)


def false(name: str, seed: int, markers: int | None = None) -> tuple[bool, list[str]]:
    """Whether it was named; what is said that is not so. markers: that are kept, at most."""
    rng = np.random.default_rng([list(KINDS).index(name), seed, 11])
    one = KINDS[name]
    values = one.drawn(rng)
    with tempfile.TemporaryDirectory() as folder:
        try:
            found, word = told(one, values, Path(folder))
        except Exception as failure:
            return False, [f"{type(failure).__name__}: {failure}"]
    said = set(found)
    wrong = sorted(said - one.names - one.beside)
    if word == "good" and not one.good:
        wrong.append("good")
    return bool(said & one.names) or not one.names, wrong


def rows(runs: int) -> Iterator[tuple[str, str, int, str, str, str]]:
    """For docs/accuracy."""
    for name, one in KINDS.items():
        told_of = [false(name, run) for run in range(runs)]
        wrong = Counter(code for _, codes in told_of for code in codes)
        named = sum(named for named, _ in told_of) / runs
        yield name, "named", runs, ">= 0.7" if one.names else "", "", f"{named:.2f}"
        listed = ", ".join(f"{code} {count}" for code, count in wrong.items())
        share = sum(bool(codes) for _, codes in told_of) / runs
        yield name, "false", runs, "<= 0.03", "", f"{share:.2f} {listed}".strip()
