"""Table and figure of a tracked receiver."""

from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.lighthouse.assess.rows import track_row
from mocap_metrology.lighthouse.records import ROLES
from mocap_metrology.lighthouse.rotation import exp
from mocap_metrology.lighthouse.track.receiver import Spread, Track, columns
from mocap_metrology.present.calibration.track_figure import track_figure
from mocap_metrology.present.plot.figure import save
from mocap_metrology.present.tables import markdown

NAMED = {"calibration": "hall-1", "setup": "hall", "source": "twin"}
N = 480
MOVED = {"rotors": []}  # allan.parquet has no rows then


def tracked(still: bool = False) -> dict[str, np.ndarray]:
    """8 s: noise 0.3, 0.4 and 1.2 mm (1.3 in all), calibration ten times, total eleven times as
    large; 60 moments seen by one station, 48 by none; jitter as the noise."""
    rng, time = np.random.default_rng(1), np.arange(N) / 60
    noise = np.tile([3e-4, 4e-4, 1.2e-3, 1e-4, 2e-4, 2e-4], (N, 1))
    place = np.array([3.0, 0.2, 0.1]) + noise[:, :3] * rng.normal(size=(N, 3))
    if not still:
        place += 0.2 * np.sin(time)[:, None]
    R = exp(noise[:, 3:] * rng.normal(size=(N, 3)))
    hits = np.full((N, 2), 50, np.int32)
    hits[100:160, 1] = 0
    hits[200:248] = 0
    by_slave = np.zeros((N, 6, 6))
    by_slave[:, :3, :3] = 0.5 * np.eye(3)
    by_slave[:, 0, 4] = 3.0
    residual = np.full(N, 5e-5)
    for values in (place, R, residual, noise, by_slave):
        values[200:248] = np.nan
    covariance = np.einsum("ni,ij->nij", (11 * noise) ** 2, np.eye(6))
    sd = Spread(noise, 10 * noise, 11 * noise, by_slave, covariance)
    return columns(Track(time, R, place, hits, residual, sd, "diode 3 excluded"))


def test_a_row_in_closed_form() -> None:
    row = track_row(NAMED, tracked(still=True), {"still": True, "tracked_with": "hall-0"})
    assert (row["stations"], row["n_poses"], row["calibration"]) == ("hall-0", 432, "hall-1")
    assert row["seen_percent"] == pytest.approx(90)
    assert row["one_station_percent"] == pytest.approx(12.5)
    numbers = {"noise_mm": 1.3, "calibration_mm": 13, "total_mm": 14.3, "residual_urad": 50}
    numbers |= {"noise_deg": np.degrees(3e-4), "gain_mm_per_mm": 0.5}
    numbers |= {"gain_mm_per_deg": 3e3 * np.radians(1) / np.sqrt(3)}
    for name, value in numbers.items():
        assert row[name] == pytest.approx(value), name
    assert row["jitter_mm"] == pytest.approx(1.3, rel=0.1)
    assert row["jitter_deg"] == pytest.approx(np.degrees(3e-4), rel=0.1)
    moving = track_row(NAMED, tracked(), {"note": "diode 3 excluded"})
    assert (moving["jitter_mm"], moving["note"], moving["stations"]) == (
        None,
        "diode 3 excluded",
        "",
    )
    none = track_row(NAMED, columns(None), {"reason": "no pose", "still": True})
    assert (none["n_poses"], none["noise_mm"], none["note"]) == (0, None, "no pose")
    text = markdown([row, moving, none], "hall: tracked receivers", "Twins.")
    assert text.startswith("# hall: tracked receivers\n") and "| no pose" in text
    assert (
        markdown([], "hall: tracked receivers", "", "None.")
        == "# hall: tracked receivers\n\nNone.\n"
    )


@pytest.mark.parametrize("still", [False, True])
def test_the_figure_shows_gaps_and_both_sources(tmp_path: Path, still: bool) -> None:
    picture = track_figure("hall-1", "real-1-1", tracked(still), {"still": still}, {}, MOVED)
    axes = {axes.get_title(loc="left")[:3]: axes for axes in picture.figure.axes}
    assert set(axes) >= {"(a)", "(b)", "(c)", "(d)", "(e)"}
    place, sd = axes["(c)"], axes["(d)"]
    assert np.isnan(place.lines[0].get_ydata()[200:248]).all()
    assert np.nanmax(np.abs(place.lines[0].get_ydata())) < (5.0 if still else 0.5)
    shown = {line.get_label(): np.nanmean(line.get_ydata()) for line in sd.lines}
    assert shown["error of the calibration"] == pytest.approx(13)
    assert shown["noise of the hits"] == pytest.approx(1.3)
    assert ("jitter" in place.get_title(loc="right")) == still
    assert ("The board was at rest" in picture.caption) == still
    assert [path.stat().st_size > 10_000 for path in save(picture, tmp_path / "track")] == [
        True
    ] * 2


def test_at_rest_the_figure_shows_the_noise_of_the_angles() -> None:
    """Four curves of white noise in the panel of azimuth; none in that of elevation, which says so;
    the clock's rounding is step / sqrt(24) at one sweep."""
    tau = np.array([1, 2, 5, 10]) / 30
    parts = [f"{role}_azimuth_{part}" for role in ROLES for part in ("common", "independent")]
    adev = np.concatenate([5e-5 / np.sqrt(k * tau) for k in (1, 2, 3, 4)])
    allan = {"series": np.repeat(parts, 4).astype(object), "estimator": np.full(16, "oadev")}
    allan |= {"tau_s": np.tile(tau, 4), "adev_rad": adev}
    allan |= {"adev_lower_rad": 0.9 * adev, "adev_upper_rad": 1.1 * adev}
    noise = {"rotors": [{"step_rad": 188e-6}]}
    picture = track_figure("desk", None, tracked(True), {"still": True}, allan, noise)
    titled = {axes.get_title(loc="left"): axes for axes in picture.figure.axes}
    shown = titled["(a) Angles at rest, azimuth"]
    lines = {line.get_label(): line for line in shown.lines}
    np.testing.assert_allclose(lines["slave, common part"].get_ydata(), 1e6 * adev[8:12])
    rounding = lines["rounding by the clock, dithered"]
    level = rounding.get_ydata() * np.sqrt(rounding.get_xdata() / tau[0])
    np.testing.assert_allclose(level, 188 / np.sqrt(24))
    assert not titled["(b) Angles at rest, elevation"].lines
