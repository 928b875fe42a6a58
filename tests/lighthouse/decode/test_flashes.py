"""Flashes: codes, cycles and clocks of recordings whose every flash is known."""

from dataclasses import replace

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.decode.comb import pattern_of
from mocap_metrology.lighthouse.decode.flashes import expect_unbroken, find_flashes, within_flashes
from mocap_metrology.lighthouse.records import Flashes, Pulses

from .synthetic import TICK, Scene, add, by_start, drop

HALF_SAMPLE_S = 0.25e-6  # a sampled edge comes late by half a sample on average
LONG_S = 45e-6


def check(
    scene: Scene, found: list[Flashes], least: float = 1.0, within_s: float = 0.12e-6
) -> None:
    """Codes where they are told, and begins of cycles, are the true ones.

    At the nominal period, 16,666 2/3 samples, an edge meets three phases of the sampling only, so
    that their mean may be off by 1/6 sample, 83 ns; real rotors differ from it.
    """
    shift = None
    for own, station in zip(found, scene.stations, strict=True):
        number = np.round((own.time_s - scene.begins[station, 0]) / scene.cycle_s).astype(int)
        shifts = np.unique(number - own.cycle)
        assert shifts.size == 1
        assert shift in (None, shifts[0])  # one numbering for both
        shift = shifts[0]
        told = own.code >= 0
        assert told.mean() >= least
        np.testing.assert_array_equal(own.code[told], scene.codes[station, number[told]])
        error = own.clock.start(own.cycle) - scene.begins[station, number] - HALF_SAMPLE_S
        assert np.abs(error).max() < within_s
        assert (np.diff(own.cycle) > 0).all()


@pytest.mark.parametrize("bias_s", [-4e-6, 4e-6])
@pytest.mark.parametrize("below_ticks", [0, 125, 250, 375, 499])
def test_all_codes_at_every_width_and_bias(below_ticks: int, bias_s: float) -> None:
    scene = Scene(below_ticks=below_ticks, bias_s=bias_s).build()
    found = find_flashes(scene.pulses())
    check(scene, found)
    assert [f.station for f in found] == [0, 1]
    for own in found:
        assert np.bincount(own.code, minlength=8).min() > 0
        nominal = (3000 + 500 * own.code.astype(float)) * TICK
        np.testing.assert_allclose(own.length_s, nominal, atol=1e-6)
        assert own.cycle[0] == 0


SCENES = {
    **{f"from {t} s, phase {k}": {"begin_s": t, "phase": k}
       for t in (-4e-3, -3e-4, 1e-5, 7.9e-3) for k in range(4)},
    **{f"station {k} alone, phase {p}": {"stations": (k,), "phase": p}
       for k in (0, 1) for p in (0, 1)},
    "all bits 0": {"data": np.zeros((2, 300), int)},
    "all bits 1": {"data": np.ones((2, 300), int)},
    **{f"a sweep each cycle, bits {data}, phase {p}":
       {"stations": (0,), "alone": True, "phase": p,
        "data": None if data is None else np.full((2, 300), data)}
       for data in (None, 0, 1) for p in (0, 1)},
    "sweeps as long as flashes": {"width_s": 70e-6},  # from decimetres; each fourth cycle
}  # fmt: skip


@pytest.mark.parametrize("case", SCENES)
def test_scenes_of_every_kind(case: str) -> None:
    scene = Scene(**SCENES[case]).build()
    found = find_flashes(scene.pulses())
    check(scene, found)
    assert min(f.cycle[0] for f in found) == 0
    assert [f.station for f in found] == list(range(len(scene.stations)))
    if scene.alone:
        assert sorted(pattern_of(found[0].cycle, found[0].code)) == [0, 0, 1, 1]


@pytest.mark.parametrize("ppm", [-97.3, 83.1, 300.7])
def test_period_is_measured(ppm: float) -> None:
    scene = Scene(seconds=8.0, cycle_s=400_000 * TICK * (1 + ppm * 1e-6)).build()
    for own in find_flashes(scene.pulses()):
        assert abs(own.clock.cycle_s / scene.cycle_s - 1) < 0.05e-6
    check(scene, find_flashes(scene.pulses()), within_s=0.02e-6)


def test_false_and_merged_flashes() -> None:
    """One false flash for two true ones, on one diode or all; and light that runs into flashes."""
    scene, rng = Scene(seconds=4.0).build(), np.random.default_rng(7)

    def length(n: int) -> np.ndarray:
        return rng.uniform(50e-6, 140e-6, n)

    false = add(scene.pulses(), rng.uniform(0, 4, 900), length(900), rng.integers(0, 32, 900))
    bursts = np.repeat(rng.uniform(0, 4, 60), 32)
    false = add(false, bursts, np.repeat(length(60), 32), np.tile(np.arange(32), 60))
    merged = (false.length_s > LONG_S) & (rng.uniform(size=false.start_s.size) < 0.05)
    early = np.where(merged, rng.uniform(0, 50e-6, merged.size), 0)
    pulses = by_start(false, false.start_s - early, false.length_s + early, false.diode)
    found = find_flashes(pulses)
    check(scene, found, 0.97)
    assert min(f.cycle.size for f in found) > 470


def with_memory(pulses: Pulses, wait_s: float, n: int) -> Pulses:
    """The recording, and before it n pulses of an earlier one, `wait_s` of silence between."""
    first = pulses.start_s[n] + wait_s
    late = replace(pulses, start_s=pulses.start_s + first, duration_s=pulses.duration_s + first)
    return add(late, pulses.start_s[:n], pulses.length_s[:n], pulses.diode[:n])


@pytest.mark.parametrize("n", [1, 40, 1000])
def test_pulses_of_a_devices_memory_are_left_out(n: int) -> None:
    """3 s after half a minute of silence are 3 s; so are pauses within a recording."""
    scene = Scene(seconds=3.0).build()
    whole = scene.pulses()
    pulses, before = within_flashes(whole, find_flashes(whole))
    assert pulses.duration_s == pytest.approx(3.0, abs=0.02) and not pulses.notes
    assert len(pulses.start_s) == len(whole.start_s)
    older = with_memory(whole, 36.7, n)
    late, again = within_flashes(older, find_flashes(older))
    assert late.duration_s == pytest.approx(pulses.duration_s, abs=0.01)
    assert len(late.start_s) == len(pulses.start_s)
    assert late.notes[0].startswith(f"{n} pulses before or after the stations' flashes ignored")
    for a, b in zip(before, again, strict=True):
        assert (a.code == b.code).all()
    hidden = drop(whole, (whole.start_s > 0.6) & (whole.start_s < 2.0))
    assert within_flashes(hidden, find_flashes(hidden))[0].duration_s == pytest.approx(
        3.0, abs=0.02
    )


def test_no_flashes() -> None:
    scene = Scene().build()
    pulses = scene.pulses()
    with pytest.raises(Refusal, match="no flashes"):
        find_flashes(drop(pulses, pulses.length_s > LONG_S))
    rng = np.random.default_rng(1)
    none = drop(pulses, pulses.length_s > LONG_S)
    for n in (30, 3000):
        random = add(none, rng.uniform(0, 2, n), rng.uniform(50e-6, 140e-6, n), [0] * n)
        with pytest.raises(Refusal, match=r"do not repeat every 8\.333 ms"):
            find_flashes(random)


@pytest.mark.filterwarnings("error")
def test_flashes_at_half_the_rate_are_refused() -> None:
    pulses = Scene().build().pulses()
    with pytest.raises(Refusal, match="not evenly spaced"):
        find_flashes(replace(pulses, start_s=2.0 * pulses.start_s))


@pytest.mark.parametrize("at_s", [0.7, 1.3])
@pytest.mark.parametrize("cycles", [4.668, 1, 2, 7])
def test_samples_that_were_lost_are_noticed(at_s: float, cycles: float) -> None:
    """Whole cycles, too, which leave the clocks as they are and turn the codes."""
    pulses, lost_s = Scene().build().pulses(), cycles / 120
    expect_unbroken(pulses, find_flashes(pulses), "a.bin")
    kept = drop(pulses, (pulses.start_s > at_s) & (pulses.start_s < at_s + lost_s))
    cut = replace(kept, start_s=kept.start_s - lost_s * (kept.start_s > at_s))
    with pytest.raises(Refusal, match=r"a\.bin: about [2-4]\d% .*samples were lost"):
        expect_unbroken(cut, find_flashes(cut), "a.bin")
