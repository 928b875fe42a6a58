"""Gyroscope and accelerometer of a simulated board."""

from __future__ import annotations

import numpy as np

from mocap_metrology.lighthouse.batch.problem import GRAVITY_M_S2
from mocap_metrology.lighthouse.records import Inertial
from mocap_metrology.lighthouse.rotation import exp, log
from mocap_metrology.lighthouse.simulate.motion import Motion
from mocap_metrology.lighthouse.simulate.twin import InertialTwin

STEP_S = 1e-3  # of the differences: errors of 1e-6 of the acceleration of a hand


def sensed(
    motion: Motion, up: np.ndarray, twin: InertialTwin, duration_s: float, rng: np.random.Generator
) -> Inertial:
    """What the sensors of a board record; up (3,): the way up in the frame of the motion.

    Rates and forces are central differences of the motion over 2 ms, with bias, scale, another
    orientation than stated, and white noise.
    """
    time_s = np.arange(0.0, duration_s, 1 / twin.rate_hz)
    then = time_s - 1e-3 * twin.delay_ms
    before, now, after = (motion.poses(then + shift) for shift in (-STEP_S, 0.0, STEP_S))
    place = np.array(twin.place_m) + 1e-3 * twin.place_error_mm * rng.standard_normal(3)
    q = [p + R @ place for R, p in (before, now, after)]
    a = (q[0] - 2 * q[1] + q[2]) / STEP_S**2 + GRAVITY_M_S2 * up
    force = np.einsum("nji,nj->ni", now[0], a)
    rate = log(np.swapaxes(before[0], 1, 2) @ after[0]) / (2 * STEP_S)
    M = exp(np.radians(twin.turn_error_deg) * rng.standard_normal(3))
    bias_w, bias_f = (
        sd * rng.standard_normal(3) for sd in (twin.gyro_bias_rad_s, twin.accel_bias_m_s2)
    )
    scale = 1 + twin.accel_scale_error * rng.standard_normal()
    root = np.sqrt(twin.rate_hz / 2)  # of the bandwidth
    noise_w, noise_f = (
        root * density * rng.standard_normal(rate.shape)
        for density in (twin.gyro_density, twin.accel_density)
    )
    return Inertial(
        time_s,
        rate @ M + bias_w + noise_w,
        (force @ M + bias_f) / scale + noise_f,
        np.array(twin.place_m),
    )
