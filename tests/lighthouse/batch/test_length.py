"""Lengths that were measured in the room, in an estimate by `batch`."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.lighthouse_recordings import flight, hand, real_flight
from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess.fit_checks import Case
from mocap_metrology.lighthouse.assess.summary import summary
from mocap_metrology.lighthouse.batch import problem
from mocap_metrology.lighthouse.batch.length import LengthView, equation
from mocap_metrology.lighthouse.batch.trajectory import Trajectory
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
from mocap_metrology.lighthouse.calibrate.scene import Sensors
from mocap_metrology.lighthouse.decode.clean import clean_hits
from mocap_metrology.lighthouse.known_length import KnownLength, Place, known_length
from mocap_metrology.present.text.calibration import reason

MASTER, SLAVE = Place(station=0), Place(station=1)
PLACES = {
    "stations": (MASTER, SLAVE),
    "diode at two moments": (Place(diode=1, time_s=0.3), Place(diode=2, time_s=1.2)),
    "points": (SLAVE, Place(diode=1, time_s=0.31), Place(diode=0, time_s=1.2), MASTER),
}


@pytest.mark.parametrize("name", PLACES)
def test_derivatives_of_a_length_are_its_differences(name: str) -> None:
    rng, step = np.random.default_rng(1), 1e-6
    node_R = Rotation.random(9, random_state=1).as_matrix()
    control = 0.3 * rng.normal(size=(43, 6))
    trajectory = Trajectory(0.0, 0.05, control, np.linspace(0, 2, 9), node_R)
    of = problem.layout(2, 4, problem.Priors(), sized_scale=True)
    poses = [np.eye(3), np.eye(3)], [np.zeros(3), np.array([1.0, 2, 3])]
    state = problem.start(*poses, np.zeros((2, 2, 10)), rng.normal(size=(4, 3)), of.size)
    seen = LengthView.of(KnownLength(PLACES[name], 1.0, 0.1), trajectory)
    found = equation(seen, control, state, of)

    def difference(moved: np.ndarray, then: problem.State) -> float:
        return (equation(seen, moved, then, of).residual - found.residual) / step

    each = step * np.eye(control.size)
    by = [difference(control + d.reshape(-1, 6), state) for d in each]
    np.testing.assert_allclose(found.by_trajectory, by, atol=1e-5)
    by = [difference(control, state.moved(d, of)) for d in step * np.eye(of.size)]
    np.testing.assert_allclose(found.by_others, by, atol=1e-5)


POINTS = {"master": np.zeros(3), "diode 1": np.array([3.0, 0, 0]), "slave": np.array([0, 4.0, 0])}


@pytest.mark.parametrize(
    ("cell", "places", "size_m", "sd_m"),
    [("stations 4.330 0.005", (MASTER, SLAVE), 4.33 / 2**0.5, 0.005 / 2**0.5),
     ("diode 0 at 2.0 s - diode 3 at 7.25 s 2 0.002",
      *((Place(diode=0, time_s=2.0), Place(diode=3, time_s=7.25)), 2**0.5, 0.002 / 2**0.5)),
     ("points", (MASTER, Place(diode=1), SLAVE), (50 / 3) ** 0.5, 0.005),
     ("points 0.001", (MASTER, Place(diode=1), SLAVE), (50 / 3) ** 0.5, 0.001),
     ("stations 100 0.000000001", (MASTER, SLAVE), 5000**0.5, 1e-9 / 2**0.5),
     ("stations 2 1.999", (MASTER, SLAVE), 2**0.5, 1.999 / 2**0.5)],
)  # fmt: skip
def test_a_length_in_a_cell(cell: str, places, size_m: float, sd_m: float) -> None:
    found = known_length(cell, 4, POINTS)
    assert found.places == places
    assert (found.size_m, found.sd_m) == pytest.approx((size_m, sd_m))


@pytest.mark.parametrize(
    ("cell", "why"),
    [
        ("stations 4.33", "expected `stations 4.330 0.005`"),
        ("stations 100.0001 0.005", "expected `stations"),
        ("stations 2 2", "expected `stations"),
        ("stations 4.33 0", "expected `stations"),
        ("points 0.0", "expected `stations"),
        ("diode 4 at 2 s - diode 0 at 7 s 2 0.002", "the board has the diodes 0 to 3"),
        ("diode 0 - diode 1 2 0.002", "expected `stations"),
    ],
)
def test_cells_that_state_no_length(cell: str, why: str) -> None:
    with pytest.raises(Refusal, match=why):
        known_length(cell, 4)


def test_the_size_of_points_and_of_three_stations_needs_more() -> None:
    with pytest.raises(Refusal, match="a file of points"):
        known_length("points", 4)
    assert known_length("stations 2 0.1", 4, names=("3", "5")).places == (MASTER, SLAVE)
    with pytest.raises(Refusal):
        known_length("stations 2 0.1", 4, names=("3", "5", "7"))


def test_a_known_length_shows_the_scale_of_a_deck() -> None:
    """A deck that is 0.7 % larger than its file, with misfit in the first third and wrong sweeps:
    a length along the flight removes the error of 30 mm that `flights` of the benchmarks has."""
    flight = real_flight(2)
    truth, end = flight.made.truth, flight.made.twin.duration_s
    hits, _ = clean_hits(flight.hits, flight.board)
    time = np.linspace(0.5, end - 0.5, 100)
    R, p = truth.motion.poses(time)
    at = p + R @ truth.board[0]
    apart = np.linalg.norm(at[:, None] - at, axis=2)
    i, j = np.unravel_index(apart.argmax(), apart.shape)
    moments = [Place(diode=0, time_s=float(time[k])) for k in (i, j)]
    lengths = (KnownLength.between(*moments, apart[i, j], 2e-3),)
    settings = CalibrationSettings(estimators=("batch",), optics=("factory",))
    factories = [station.factory for station in truth.stations]
    sensors = Sensors(lengths=lengths)
    found = calibrate(hits, flight.board, factories, settings, sensors=sensors).estimates[0]
    off = 1e3 * (found.t_m - truth.t_optical_m)
    sd = np.sqrt(np.diag(found.covariance))
    turn = np.degrees(rotation.error(found.R, truth.R))
    assert np.linalg.norm(turn) < 0.1
    assert (np.abs(np.r_[off, turn]) < 2 * sd).all()
    assert np.linalg.norm(off) < 5 < np.linalg.norm(sd[:3]) < 12


def test_a_length_at_a_moment_that_no_hit_shows_is_noted() -> None:
    made = hand(1)
    hits, factories = made.hits, [station.factory for station in made.truth.stations]
    hits = hits.take((hits.time_s < 3) | (hits.time_s > 3.5))
    settings, notes = CalibrationSettings(("batch",), ("factory",), variant="libsurvive"), []
    for time_s in (2.0, 3.25):
        places = Place(diode=0, time_s=5.0), Place(diode=0, time_s=time_s)
        sensors = Sensors(lengths=(KnownLength.between(*places, 0.2, 0.002),))
        found = calibrate(hits, made.truth.board, factories, settings, sensors=sensors)
        notes.append(found.estimates[0].note)
    assert not notes[0]
    assert "times less certain, as the place of the board is at 5 s, 3.25 s" in notes[1]


@pytest.mark.parametrize("wrong", [0.98, 1.02])
def test_what_a_length_says_of_the_deck_and_the_deck_of_it(wrong: float) -> None:
    """By a length of 4.3 m that is 2 % wrong the deck is as much larger than it is: in standard
    deviations of its size, (0.3 mm)^2 over its largest extent. Two independent values of the scale
    share it by the inverse of their variances."""
    made, sd_m = flight(1, seconds=10.0), 0.02
    larger = 1.007
    deck = made.truth.board / larger
    hits, _ = clean_hits(made.hits, deck)
    apart = float(np.linalg.norm(made.truth.t_optical_m))
    lengths = (KnownLength.between(Place(station=0), Place(station=1), wrong * apart, sd_m),)
    settings = CalibrationSettings(("batch",), ("factory",), variant="libsurvive")
    factories = [station.factory for station in made.truth.stations]
    found = calibrate(hits, deck, factories, settings, sensors=Sensors(lengths=lengths))
    stations = [replace(station, frames_found=1) for station in made.truth.stations]
    told = summary(found, stations, duration_s=10.0)
    check = next(check for check in told.verdict.checks if check.case is Case.LENGTH)
    own = 3e-4 / np.hypot(0.03, 0.015)
    length = sd_m / apart
    share = own**2 / (own**2 + length**2)
    expected = share * (larger * wrong - 1)
    assert check.numbers["percent"] == pytest.approx(100 * share, abs=3.0)  # places of diodes count
    assert check.numbers["larger"] == pytest.approx(100 * expected, abs=0.1)
    assert check.value == pytest.approx(
        (larger * wrong - 1) / np.hypot(own, length), rel=0.1, abs=0.1
    )


@pytest.mark.parametrize("wrong", [0.99, 1.0, 1.01])
def test_an_error_of_a_length_that_a_deck_does_not_show_is_told(wrong: float) -> None:
    """A length that is 1 % wrong, ten times its standard deviation, moves the pose by as much, and
    a deck of 33 mm, known to 0.3 mm and diodes to 0.2 mm, is as well 1 % larger: the verdict says
    what would not be noticed, 2.58 of all these standard deviations (probability 1 %)."""
    made = flight(1, seconds=8.0)
    hits, _ = clean_hits(made.hits, made.truth.board)
    apart = float(np.linalg.norm(made.truth.t_optical_m))
    length = KnownLength.between(MASTER, SLAVE, wrong * apart, 1e-3 * apart)
    settings = CalibrationSettings(("batch",), ("factory",), variant="libsurvive")
    factories = [station.factory for station in made.truth.stations]
    sensors = Sensors(lengths=(length,))
    found = calibrate(hits, made.truth.board, factories, settings, sensors=sensors)
    stations = [replace(station, frames_found=1) for station in made.truth.stations]
    told = summary(found, stations, duration_s=8.0).verdict
    (check,) = (check for check in told.checks if check.name == "scale")
    assert (told.word, check.case) == ("good", Case.SCALE_OPEN)
    assert "would not show a known length that is wrong by up to 2." in reason(told)
    places = (
        found.estimates[0].details["board_position_mm"] * 1e-3 / np.linalg.norm(made.truth.board)
    )
    all_of_it = np.linalg.norm([3e-4 / np.hypot(0.03, 0.015), 1e-3, places])
    assert check.numbers["percent"] == pytest.approx(100 * 2.576 * all_of_it, rel=0.05)


def test_a_wrong_length_beside_a_large_board_is_noticed() -> None:
    """24 cm known to 0.12 %, against a length that is 1 % wrong and stated to 0.1 %."""
    made = hand(1)
    settings = CalibrationSettings(("batch",), ("factory",), variant="libsurvive")
    apart = float(np.linalg.norm(made.truth.t_optical_m))
    words = []
    for wrong in (1.0, 1.01):
        sensors = Sensors(
            lengths=(KnownLength.between(MASTER, SLAVE, wrong * apart, 1e-3 * apart),)
        )
        factories = [station.factory for station in made.truth.stations]
        found = calibrate(made.hits, made.truth.board, factories, settings, sensors=sensors)
        stations = [replace(station, frames_found=1) for station in made.truth.stations]
        told = summary(found, stations, duration_s=8.0).verdict
        assert any(check.case is Case.SCALE for check in told.checks)
        words.append(told.word)
    assert words == ["good", "doubtful"]
