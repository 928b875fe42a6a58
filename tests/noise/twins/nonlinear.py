"""Triangulation without linearising, to check the linear one against."""

from collections.abc import Sequence

import numpy as np

from mocap_metrology.noise.twins.take import Facility


def project(facility: Facility, points_mm: np.ndarray) -> np.ndarray:
    """(n, 2) pixels at which the cameras see one point (3,), or each its own (n, 3)."""
    seen = np.einsum("nij,nj->ni", facility.rotations, points_mm - facility.origins_mm)
    return facility.focal_px[:, None] * seen[:, :2] / seen[:, 2:]


def triangulate(
    facility: Facility, pixels: np.ndarray, subset: Sequence[int], start_mm: np.ndarray
) -> np.ndarray:
    """(3,) point with the least sum of squared residuals (two a camera). pixels: (n, 2)."""
    from scipy.optimize import least_squares

    own = list(subset)

    def residual(point: np.ndarray) -> np.ndarray:
        return (project(facility, point)[own] - pixels[own]).ravel()

    return least_squares(residual, start_mm, x_scale=1.0, xtol=1e-15, ftol=1e-15, gtol=1e-15).x
