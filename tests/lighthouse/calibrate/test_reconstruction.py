"""Both angles at one moment: exact for angles that move evenly, never across a gap (J IV)."""

import numpy as np
import pytest

from mocap_metrology.lighthouse.calibrate.reconstruction import reconstruct
from mocap_metrology.lighthouse.records import Hits

CYCLE_S = 1 / 120
DIODES = 6


def azimuth(time_s: np.ndarray, diode: np.ndarray) -> np.ndarray:
    return 0.1 + 0.05 * diode + 0.02 * time_s


def elevation(time_s: np.ndarray, diode: np.ndarray) -> np.ndarray:
    return -0.2 + 0.03 * diode + 0.3 * time_s


def even_hits(n_cycles: int = 400) -> Hits:
    """One station that sweeps in two of four cycles; angles linear in time."""
    c, d = np.meshgrid(np.arange(n_cycles), np.arange(DIODES), indexing="ij")
    c, d = c[c % 4 >= 2], d[c % 4 >= 2]
    axis = c % 4 - 2
    time = (c + 0.5) * CYCLE_S + 1e-5 * d
    angle = np.where(axis == 0, azimuth(time, d), elevation(time, d))
    n = c.size
    whole = {"station": np.ones(n, np.int8), "axis": axis.astype(np.int8), "cycle": c, "diode": d}
    return Hits(**whole, time_s=time, angle_rad=angle, width_s=np.full(n, 4e-6))


@pytest.mark.parametrize("method", ["full-interpolation", "dominant-axis"])
def test_interpolation_is_exact_for_even_motion(method: str) -> None:
    found = reconstruct(even_hits(), 1, DIODES, method)
    diode = np.arange(DIODES)
    for time, angles in zip(found.time_s, found.angles_rad, strict=True):
        own = time + 1e-5 * (diode - diode.mean())
        np.testing.assert_allclose(angles[:, 0], azimuth(own, diode), atol=1e-12)
        np.testing.assert_allclose(angles[:, 1], elevation(own, diode), atol=1e-12)


def test_how_many_measurements_each_method_makes() -> None:
    """100 sweeps of each axis: at 199 of all there is one of the other axis on both sides; the
    dominant axis is the one that moves more (elevation); each azimuth has its elevation."""
    counts = {
        method: len(reconstruct(even_hits(), 1, DIODES, method))
        for method in ("full-interpolation", "dominant-axis", "pairs")
    }
    assert counts == {"full-interpolation": 198, "dominant-axis": 99, "pairs": 100}
    assert len(reconstruct(even_hits(399), 1, DIODES, "pairs")) == 99  # the last is an azimuth
    times = reconstruct(even_hits(), 1, DIODES, "dominant-axis").time_s
    assert (np.round(times / CYCLE_S - 0.5).astype(int) % 4 == 3).all()


def test_nothing_is_made_of_nothing() -> None:
    """A diode unseen in one sweep is missing there and where it would be interpolated from; no
    interpolation across lost sweeps; none of another station."""
    hits = even_hits()
    lost = (hits.cycle == 102) & (hits.diode == 3)  # an azimuth
    found = reconstruct(hits.take(~lost), 1, DIODES)
    missing = ~found.seen[:, 3]
    cycles = np.round(found.time_s[missing] / CYCLE_S - 0.5).astype(int)
    assert cycles.tolist() == [99, 102, 103] and found.seen[:, :3].all()
    gap = (hits.cycle >= 100) & (hits.cycle < 140) & (hits.axis == 0)
    cycles = np.round(reconstruct(hits.take(~gap), 1, DIODES).time_s / CYCLE_S - 0.5).astype(int)
    assert not ((cycles > 98) & (cycles < 142)).any() and cycles.size > 170
    assert len(reconstruct(hits, 0, DIODES)) == 0
