"""Measurements of both stations as an optics sees them: ideal, or with factory values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.lighthouse.calibrate.reconstruction import Measurements
from mocap_metrology.lighthouse.records import Factory
from mocap_metrology.lighthouse.rotor import VARIANTS, directions, rotor_parameters


@dataclass(frozen=True)
class Optics:
    """Measurements of both stations as an optics sees them, and the rotors that go with these."""

    name: str
    measurements: tuple[Measurements, Measurements]
    rotors: tuple[np.ndarray, np.ndarray]
    frame: str  # optical, or housing where the lasers' places are named


def optics_of(
    name: str,
    measured: Sequence[Measurements],
    factories: Sequence[Factory | None],
    lasers_m: np.ndarray | None,
    variant: str,
) -> Optics:
    """With lasers in the origin, factory values are taken off the angles once and for all (to
    1e-12 rad); with lasers elsewhere they stay in the model."""
    lasers = [None, None] if lasers_m is None else lasers_m
    frame = "optical" if lasers_m is None else "housing"
    if name == "ideal":
        rotors = tuple(rotor_parameters(None, own) for own in lasers)
        return Optics(name, tuple(measured), rotors, frame)
    model = VARIANTS[variant]
    if lasers_m is not None:
        both = zip(factories, lasers, strict=True)
        rotors = tuple(rotor_parameters(factory, own, model) for factory, own in both)
        return Optics(name, tuple(measured), rotors, frame)
    corrected = tuple(
        Measurements(own.time_s, directions(own.angles_rad, rotor_parameters(f, None, model)))
        for own, f in zip(measured, factories, strict=True)
    )
    return Optics(name, corrected, (rotor_parameters(), rotor_parameters()), frame)
