"""A shock is found where it was put, and cutting it out leaves what was there without it."""

from dataclasses import replace

import numpy as np
import pytest
from figure_data import check, every_text
from mocap_workflow.recording_twins import twin_from_mapping
from noise_data import assert_texts_apart

from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.series import all_series, allan_columns
from mocap_metrology.noise.twins.simulate import simulate
from mocap_metrology.papers.shock import CUT, RECORDED, Shaken, find_shock
from mocap_metrology.present.skurowski.crump import crump_figure

pytestmark = pytest.mark.filterwarnings("error")
RATE, SECONDS = 120.0, 300.0
CRUMP = {"time_share": 0.4, "amplitude_mm": 0.5, "decay_s": 2, "frequency_hz": 3}
NAMES = [f"{axis}{k}" for k in (1, 2) for axis in "xyz"]


def made(crump) -> tuple[dict, float | None]:
    twin = twin_from_mapping(
        {"published": {"camera_type": "T40", "n_cameras": 10}, "seed": 5, "crump": CRUMP}, "T"
    )
    told = simulate(twin if crump else replace(twin, crump=None), SECONDS)
    values = dict(zip(NAMES, told.position_mm.reshape(6, -1), strict=True))
    return dict(all_series(values, [(1, 2)])), crump and told.truth["crump"]["time_s"]


@pytest.fixture(scope="module")
def shaken():
    return made(True)


@pytest.fixture(scope="module")
def quiet():
    return made(False)[0]


def coordinates(series: dict) -> dict:
    return {name: series[name] for name in NAMES}


def columns(series: dict) -> dict:
    """allan.parquet as the workflow would write it."""
    curve = allan_curve(series["L"], RATE, averaging_factors(series["L"].size, 60))
    return allan_columns("L", curve)


def test_a_shock_is_found_where_it_was_put(shaken) -> None:
    """Calmed down to less than the short-term noise, 10 um of 0.5 mm, after 8 s."""
    series, time_s = shaken
    found = find_shock(coordinates(series), RATE)
    assert found.onset / RATE == pytest.approx(time_s, abs=0.1)
    assert found.start <= time_s * RATE and time_s + 6 < found.stop / RATE < time_s + 12
    still = {"x1": np.zeros(1000)}
    assert find_shock(still, RATE) is None
    assert find_shock({"x1": np.full(1000, np.nan)}, RATE) is None


def test_cut_out_leaves_the_deviation_without_a_shock(shaken, quiet) -> None:
    """Same noise with and without: 4 % of it is cut, so 2 to 8 % remain between the two."""
    series, _ = shaken
    given = Shaken(series, series, columns(series), RATE)
    curves = given.curves(find_shock(coordinates(series), RATE)).groupby("curve")
    recorded, cut = (curves.get_group(name).reset_index() for name in (RECORDED, CUT))
    without = columns(quiet)["adev_mm"]
    short = recorded.x < 3
    assert np.abs(cut.y / without - 1)[short].max() < 0.08
    assert np.abs(cut.y / without - 1)[recorded.x < 0.1].max() < 0.02
    near = np.abs(np.log(recorded.x * 3 * 2)) < 0.3  # half a period of 3 Hz
    assert np.all(recorded.y[near] > 3 * without[near])


@pytest.mark.parametrize("other", [True, False])
def test_the_figure(shaken, quiet, other) -> None:
    series, _ = shaken
    clean = {name: values.astype(np.float32) for name, values in series.items()}
    clean["x1"][int(121 * RATE)] += 1.0
    raw = {name: clean[name].astype(np.float64) for name in series}
    raw["x1"][int(121 * RATE)] -= 1.0
    given = Shaken(raw, clean, columns(series), RATE)
    label = ("Q, without a shock", columns(quiet)) if other else None
    figure = crump_figure(given, label, "s", "n")
    texts = every_text(figure)
    assert "from 120.0 s" in figure.caption and " 1 of " in figure.caption
    assert ("(b) Q, without a shock" in texts) == other
    check(figure)
    assert_texts_apart(figure)
