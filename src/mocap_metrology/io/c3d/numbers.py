"""Numbers as the three processors of C3D store them: Intel, DEC (VAX), MIPS."""

from __future__ import annotations

import numpy as np

PROCESSORS = {84: "Intel", 85: "DEC", 86: "MIPS"}
BLOCK = 512  # bytes; C3D counts places in blocks from 1


def byte_order(processor: int) -> str:
    """numpy's mark of the byte order: MIPS is big-endian, Intel and DEC are little-endian."""
    return ">" if processor == 86 else "<"


def raw_dtype(processor: int, is_float: bool) -> np.dtype:
    """A stored word of the data section; DEC floats as uint32, for `ieee_from_dec`."""
    kind = "i2" if not is_float else "u4" if processor == 85 else "f4"
    return np.dtype(byte_order(processor) + kind)


def ieee_from_dec(bits: np.ndarray) -> np.ndarray:
    """float32 values of DEC F_floating numbers that were read as little-endian uint32.

    F_floating stores its more significant 16-bit word first; its exponent bias is 128 with the
    mantissa in [0.5, 1), so the same bits as IEEE are 4 times too large. Two is taken off the
    exponent rather than dividing, because DEC's largest exponent would read as infinity.
    Below 2^-126 the result is zero.
    """
    bits = np.asarray(bits, dtype=np.uint32)
    swapped = (bits << np.uint32(16)) | (bits >> np.uint32(16))
    small = (swapped & np.uint32(0x7F800000)) < np.uint32(3 << 23)
    return np.where(small, np.uint32(0), swapped - np.uint32(2 << 23)).view(np.float32)


def floats(raw: bytes, processor: int) -> np.ndarray:
    """float32 values of whole 4-byte words."""
    words = np.frombuffer(raw, raw_dtype(processor, is_float=True))
    return ieee_from_dec(words) if processor == 85 else words.astype(np.float32)


def int16s(raw: bytes, processor: int) -> np.ndarray:
    """Signed 16-bit values, as int64."""
    return np.frombuffer(raw, byte_order(processor) + "i2").astype(np.int64)


def unsigned(value: int) -> int:
    """A signed 16-bit word read as unsigned."""
    return int(value) & 0xFFFF
