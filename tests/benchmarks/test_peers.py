"""The part of the comparison with peers that needs none of them."""

from benchmarks.peers import SOLVER, measure


def test_two_base_stations_from_sixty_poses() -> None:
    """60 urad of 60 poses of 32 diodes, 1 to 4 m away: tenths of a millimetre."""
    off = measure(SOLVER, series=False)["off"]
    assert off["mm"] < 0.2 and off["deg"] < 0.005
