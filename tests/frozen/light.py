"""Faults of light on photodiodes in doses, from none that matters to what is refused. Of the first
generation the light is made from first principles (`tests/lighthouse/decode/synthetic.py`)."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.decode.chain import decode
from mocap_metrology.lighthouse.decode.clean import clean_hits
from mocap_metrology.lighthouse.decode.flashes import find_flashes, find_hits, within_flashes
from mocap_metrology.lighthouse.decode.gates import Cleaning
from mocap_metrology.lighthouse.decode.ootx import decode_station
from mocap_metrology.lighthouse.records import Pulses
from mocap_metrology.lighthouse.simulate import turns
from tests.lighthouse.decode.synthetic import BOARD, Scene, add, by_start, drop

from .calibrations import twin
from .digest import Flat, flat

Fault = Callable[[np.random.Generator, Pulses, float], Pulses]
FLASH_S = 45e-6  # longer than any sweep


def lost(rng: np.random.Generator, of: Pulses, dose: float) -> Pulses:
    return drop(of, rng.random(of.start_s.size) < dose)


def no_flashes(rng: np.random.Generator, of: Pulses, dose: float) -> Pulses:
    """Whole flashes are missing, on all diodes."""
    flash = np.round(of.start_s / 2e-3).astype(int)
    return drop(of, (of.length_s > FLASH_S) & (rng.random(flash.max() + 1) < dose)[flash])


def false(length_s: float, rng: np.random.Generator, of: Pulses, dose: float) -> Pulses:
    n = round(dose * of.start_s.size)
    when = np.round(rng.uniform(0, of.duration_s - 1e-3, n) * 2e6) / 2e6
    return add(of, when, np.full(n, length_s), rng.integers(0, len(BOARD), n))


def late(rng: np.random.Generator, of: Pulses, dose: float) -> Pulses:
    """Sweeps scatter by so many seconds."""
    off = dose * rng.standard_normal(of.start_s.size) * (of.length_s < FLASH_S)
    return by_start(of, of.start_s + off, of.length_s, of.diode)


def wide(rng: np.random.Generator, of: Pulses, dose: float) -> Pulses:
    """One sweep pulse in twenty is so many times as wide."""
    some = (of.length_s < FLASH_S) & (rng.random(of.start_s.size) < 0.05)
    return by_start(of, of.start_s, of.length_s * np.where(some, dose, 1.0), of.diode)


def reflected(rng: np.random.Generator, of: Pulses, dose: float) -> Pulses:
    """One sweep pulse in thirty comes so much later."""
    some = (of.length_s < FLASH_S) & (rng.random(of.start_s.size) < 0.033)
    return by_start(of, of.start_s + dose * some, of.length_s, of.diode)


def dark(rng: np.random.Generator, of: Pulses, dose: float) -> Pulses:
    """So many diodes see nothing."""
    return drop(of, of.diode < dose)


def hidden(rng: np.random.Generator, of: Pulses, dose: float) -> Pulses:
    """No light for so many seconds."""
    return drop(of, abs(of.start_s - 0.45) < dose / 2)


FAULTS: dict[str, tuple[Fault, tuple[float, ...]]] = {
    "lost pulses": (lost, (0.02, 0.1, 0.3, 0.6, 0.9)),
    "lost flashes": (no_flashes, (0.02, 0.1, 0.3, 0.6, 0.9)),
    "false sweeps": (partial(false, 5e-6), (0.01, 0.05, 0.2, 1.0)),
    "false flashes": (partial(false, 80e-6), (0.01, 0.05, 0.2)),
    "late sweeps": (late, (1e-6, 5e-6, 2e-5, 1e-4)),
    "wide sweeps": (wide, (0.3, 1.3, 1.7, 2.3, 3.0, 4.0)),
    "reflections": (reflected, (1e-5, 3e-5, 1e-4, 3e-4, 1e-3)),
    "dark diodes": (dark, (1, 8, 20, 28, 29)),
    "no light": (hidden, (0.1, 0.4, 0.7)),
}
SCENES = {
    "brief": [Scene(seconds=s) for s in (0.15, 0.3, 0.5)],
    "moved": [Scene(seconds=0.6, velocity=(0.0, v, 0.0)) for v in (0.2, 1.0, 3.0)],
    "slow clock": [Scene(cycle_s=400_000 * (1 + p) / 48e6) for p in (1e-4, 1e-3, 5e-3)],
    "biased": [Scene(seconds=0.6, bias_s=b) for b in (-4e-6, 2e-6, 4e-6, 8e-6)],
}


def decoded(pulses: Pulses) -> object:
    """What the decoder of the first generation makes of them, or why it refuses."""
    try:
        used, flashes = within_flashes(pulses, find_flashes(pulses))
        hits, report = find_hits(used, flashes)
        kept, dropped = clean_hits(hits, BOARD, Cleaning(), np.pi * 5e-7 * 120)
        clocks = [one.clock for one in flashes]
        stations = [decode_station(one) for one in flashes]
        return {"kept": kept, "report": report | dropped, "clocks": clocks, "stations": stations}
    except Refusal as refusal:
        return str(refusal)


def faults(name: str, folder: Path | None = None) -> Flat:
    make, doses = FAULTS[name]
    of = Scene(seconds=1.0).build().pulses()
    rng = np.random.default_rng([12, *name.encode()])
    return dict(flat({str(dose): decoded(make(rng, of, dose)) for dose in doses}))


TURNS: dict[str, tuple[str, tuple[float, ...]]] = {
    "lost hits": ("dropout", (0.1, 0.3, 0.6, 0.9)),
    "reflected hits": ("reflections", (0.01, 0.05, 0.2)),
    "lost begins": ("lost_begins", (0.05, 0.3, 0.8)),
    "uneven begins": ("begin_ns", (300.0, 2000.0, 10_000.0)),
    "uneven turns": ("wander_ns", (1000.0, 5000.0)),
    "noisy angles": ("independent_urad", (100.0, 1000.0)),
    "brief turns": ("duration_s", (0.1, 0.2, 0.4)),
}


def of_turns(name: str, folder: Path) -> Flat:
    """What the decoder of the second generation makes of two stations, or why it refuses."""
    key, doses = TURNS[name]
    rng = np.random.default_rng(3)
    R, t, middle, up = turns.stations_around(2, rng)
    motion = twin("sim-1-1").motion.model_copy(update={"centre_m": tuple(middle)})
    board, normals = turns.ball_board(12)
    own = {"board": board, "normals": normals, "up": up, "duration_s": 0.6}
    found: Flat = {}
    for dose in doses:
        made = turns.simulate_turns(turns.TurnsTwin(11, R, t, (0, 6), motion, **own | {key: dose}))
        path = folder / "turns.rec.gz"
        turns.write_rec(path, made)
        try:
            found[str(dose)] = decode(path, "libsurvive-rec", "T20")
        except Refusal as refusal:
            found[str(dose)] = str(refusal)
    return dict(flat(found))


def scenes(name: str, folder: Path | None = None) -> Flat:
    return dict(flat({str(k): decoded(one.build().pulses()) for k, one in enumerate(SCENES[name])}))


CASES: dict[str, Callable[..., Flat]] = {
    **{f"light with {name}": partial(faults, name) for name in FAULTS},
    **{f"light, {name}": partial(scenes, name) for name in SCENES},
    **{f"light with {name}": partial(of_turns, name) for name in TURNS},
}
