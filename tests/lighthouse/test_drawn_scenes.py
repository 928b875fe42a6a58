"""A simulated dump gives its own flashes, factory values and angles back, whatever the scene."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mocap_metrology.lighthouse.decode.dump import pulses_of_words
from mocap_metrology.lighthouse.decode.factory_file import FACTORY_NAMES
from mocap_metrology.lighthouse.decode.flashes import find_flashes
from mocap_metrology.lighthouse.decode.ootx import decode_station
from mocap_metrology.lighthouse.decode.sweeps import find_hits
from mocap_metrology.lighthouse.rotor import VARIANTS
from mocap_metrology.lighthouse.simulate.recording import simulate, words_of
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin

SAMPLE_RAD = np.pi * 0.5e-6 * 120  # a sweep's angle of one sample
FACTORY = {
    "phase": (0.05, 0.024),
    "tilt": (-0.009, 0.001),
    "curve": (-0.004, -0.0015),
    "gibphase": (1.86, -0.79),
    "gibmag": (0.011, -0.011),
}
TWINS = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 99),
        "start_cycle": st.floats(0, 3.99),
        "clock_ppm": st.floats(-300, 300),
        "slave_offset_us": st.floats(-40, 40),
        "flash_shortfall_us": st.floats(0.3, 10.1),
        "flash_bias_us": st.floats(-3, 3),
        "variant": st.sampled_from(sorted(VARIANTS)),
        "tilt_deg": st.tuples(st.floats(-30, 30), st.floats(-30, 30)),
        "motion": st.fixed_dictionaries(
            {
                "pattern": st.sampled_from(("line", "arc", "circle", "hand", "still")),
                "centre_m": st.tuples(st.floats(2, 4), st.floats(0, 1), st.floats(-0.5, 0.5)),
            }
        ),
    }
)


def twin_of(keys: dict, factory: bool, mode: str) -> LighthouseTwin:
    master = {"id": 4152238579, "mode": "b", "factory": FACTORY if factory else None}
    slave = {"id": 7, "mode": mode, "position_m": (0.4, 2.2, 0.1), "rotation_deg": (8, 3, -40)}
    return LighthouseTwin(**keys, master=master, slave=slave)


@settings(max_examples=12)
@given(TWINS, st.booleans(), st.sampled_from("cA"))
def test_hits_of_a_dump_are_those_of_its_twin(keys: dict, factory: bool, mode: str) -> None:
    """Each once, of its station, axis and diode, within a sample: both edges are sampled and the
    flash is averaged. The cycles are numbered from the first that the dump holds."""
    made = simulate(twin_of({**keys, "duration_s": 1.0}, factory, mode))
    pulses = pulses_of_words(words_of(made.pulses))
    flashes = find_flashes(pulses)
    hits, report = find_hits(pulses, flashes)
    true = made.truth.hits
    shift = int(np.round((flashes[0].clock.epoch_s - made.truth.clocks[0].epoch_s) * 120))
    found = {
        (s, a, c + shift, d): k
        for k, (s, a, c, d) in enumerate(
            zip(
                *(x.tolist() for x in (hits.station, hits.axis, hits.cycle, hits.diode)),
                strict=True,
            )
        )
    }
    keys_of_true = zip(
        *(x.tolist() for x in (true.station, true.axis, true.cycle, true.diode)), strict=True
    )
    pairs = [(found.pop(key), k) for k, key in enumerate(keys_of_true) if key in found]
    assert len(pairs) >= 0.99 * len(true) and len(found) <= 0.002 * len(true)
    own, theirs = np.array(pairs).T
    error = hits.angle_rad[own] - true.angle_rad[theirs]
    assert np.abs(error).max() < 1.1 * SAMPLE_RAD
    assert np.sqrt(np.mean(error**2)) < 0.5 * SAMPLE_RAD
    assert np.abs(hits.width_s[own] - true.width_s[theirs]).max() <= 0.51e-6
    assert sum(report["hit"]) == len(hits) and sum(report["no_sweep"]) == 0


@settings(max_examples=4)
@given(TWINS, st.sampled_from("cA"))
def test_stations_of_a_dump_are_those_of_its_twin(keys: dict, mode: str) -> None:
    """Ids, modes and factory values exactly, the way up to a step of the accelerometer."""
    twin = twin_of({**keys, "duration_s": 6.0, "board": {"columns": 2, "rows": 2}}, True, mode)
    made = simulate(twin)
    for one, true in zip(find_flashes(pulses_of_words(words_of(made.pulses))), made.truth.stations,
                         strict=True):  # fmt: skip
        station = decode_station(one)
        assert (station.role, station.id, station.mode) == (true.role, true.id, true.mode)
        for name in FACTORY_NAMES:
            assert getattr(station.factory, name).tolist() == getattr(true.factory, name).tolist()
        assert np.degrees(np.arccos(min(1.0, station.gravity @ true.gravity))) < 0.6
        assert (station.firmware, station.hardware) == (436, 9) and station.frames_found >= 1
