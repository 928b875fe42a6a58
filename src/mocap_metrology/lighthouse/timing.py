"""Timing of a V1 base station, and the code its flashes carry.

A station flashes once a cycle, that is once each half turn of its two rotors. The length of the
flash encodes, in steps of 500 ticks of 48 MHz, which rotor sweeps next, one bit of the station's
calibration frame, and whether the laser stays off so that the other station can sweep.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np

Whole = TypeVar("Whole", int, np.ndarray)  # one code, or many
Number = TypeVar("Number", float, np.ndarray)

TICKS_PER_S = 48_000_000
CYCLE_TICKS = 400_000
CYCLE_S = CYCLE_TICKS / TICKS_PER_S  # 8.333 ms, half a turn
SLAVE_OFFSET_S = 20_000 / TICKS_PER_S  # the slave flashes 416.67 us after the master

CODE_STEP_S = 500 / TICKS_PER_S
CODE_0_S = 3_000 / TICKS_PER_S  # longest flash of code 0; the shortest is one step less


def flash_length(code: Number) -> Number:
    """Longest flash of a code in seconds: (3000 + 500 code) ticks."""
    return CODE_0_S + code * CODE_STEP_S


def code_of(axis: Whole, data: Whole, skip: Whole) -> Whole:
    """Code of a flash: skip * 4 + data * 2 + axis."""
    return skip * 4 + data * 2 + axis


def axis_of(code: Whole) -> Whole:
    """Rotor that turns in this cycle."""
    return code & 1


def data_of(code: Whole) -> Whole:
    """Bit of the calibration frame."""
    return code >> 1 & 1


def skip_of(code: Whole) -> Whole:
    """1 where the station's laser is off in this cycle."""
    return code >> 2 & 1
