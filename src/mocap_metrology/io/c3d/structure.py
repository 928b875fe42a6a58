"""Structure of a C3D file, checked before a single coordinate is read.

Header words after the C3D user guide (c3d.org), "The C3D file header": 1 the block of the
parameters and 0x50, 2 points, 3 analog samples per frame (all channels), 4 and 5 first and last
frame, 7-8 scale, 9 block of the data, 10 analog samples per channel and frame, 11-12 rate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal, Truncated
from mocap_metrology.io.c3d.frames import (
    Section,
    Trial,
    choose_frame_size,
    declared_counts,
)
from mocap_metrology.io.c3d.parameters import (
    BLOCK,
    PROCESSORS,
    Parameters,
    floats,
    int16s,
    read_parameters,
    unsigned,
)
from mocap_metrology.io.header import not_read, other_kind, regular_size
from mocap_metrology.io.labels import complete_labels
from mocap_metrology.io.recording import Header
from mocap_metrology.io.units import read_unit


@dataclass(frozen=True, kw_only=True)
class Structure(Header):
    """A C3D file without its coordinates. Lengths in bytes, places in bytes from the start.

    `scale` is |POINT:SCALE|, the int16 step in `unit`; `first_frame` from TRIAL where it agrees
    with the frame count, else from the header. `given_labels` are those of the file, `labels`
    completed.
    `listed`: labels that another parameter of POINT than LABELS lists, as ANGLES or POWERS.
    `missing`: parameters of POINT that ezc3d needs and the file has not.
    """

    given_labels: tuple[str, ...]
    listed: frozenset[str]
    missing: tuple[str, ...]
    n_points: int
    n_frames: int
    frame_count_source: str
    scale: float
    first_frame: int
    processor: int
    is_float: bool
    data_offset: int
    frame_bytes: int
    header_first: int
    header_last: int
    trial: Trial | None
    trial_base: int | None


@dataclass(frozen=True)
class _Header:
    """Words of the header in their order, and the processor."""

    processor: int
    n_points: int
    analog_samples: int
    first: int
    last: int
    scale: float
    data_block: int
    samples_per_channel: int
    rate: float


def inspect(path: str | Path, accept_truncated: bool = False) -> Structure:
    """Check a C3D file's structure and count its frames; no coordinate is read.

    Refuses what is not a C3D file, is damaged or cut off, has no points, or contradicts itself.
    `accept_truncated` takes the whole frames that a cut-off file holds, with a note.
    """
    path = Path(path)
    size = regular_size(path, "a C3D file")
    with path.open("rb") as stream:
        block = stream.read(BLOCK)
        start = _parameter_start(block, size, path.name)
        stream.seek(start)
        _, _, n_blocks, processor = stream.read(4)
        if processor not in PROCESSORS:
            known = ", ".join(f"{number} ({name})" for number, name in PROCESSORS.items())
            raise Refusal(f"{path.name}: damaged: processor {processor}, expected {known}")
        header = _read_header(block, processor)
        stream.seek(start)
        section = stream.read(_parameter_bytes(start, n_blocks, header, size))
    parameters = read_parameters(section, processor, path.name)
    return _structure(path, size, start, n_blocks, header, parameters, accept_truncated)


def _parameter_start(block: bytes, size: int, file: str) -> int:
    """Place of the parameter section, by the first block; refuses what is not a C3D file."""
    looks = other_kind(block, "" if block[1:2] == b"\x50" else Path(file).suffix)
    if looks is None and all(byte >= 32 or byte in b"\t\r\n" for byte in block):
        looks = "text"
    elif looks is None and not any(block):
        looks = "zeros only"
    elif looks is None and block[1:2] != b"\x50":
        looks = f"another binary format (bytes {block[:2].hex(' ')}, expected a second byte of 50)"
    if looks is not None:
        raise not_read(file, "a C3D file", looks)
    if len(block) < BLOCK:
        raise Refusal(f"{file}: cut off: {len(block)} bytes, the header alone has {BLOCK}")
    start = (block[0] - 1) * BLOCK
    if block[0] == 0 or start + 4 > size:
        raise Refusal(
            f"{file}: damaged: the parameters should be at block {block[0]},"
            f" the file has {size // BLOCK} blocks of {BLOCK} bytes"
        )
    return start


def _read_header(block: bytes, processor: int) -> _Header:
    words = [unsigned(word) for word in int16s(block[:24], processor)]
    reals = floats(block[:24], processor)
    scale, rate = float(reals[3]), float(reals[5])
    n_points, analog_samples, first, last = words[1:5]
    return _Header(
        processor, n_points, analog_samples, first, last, scale, words[8], words[9], rate
    )


def _parameter_bytes(start: int, n_blocks: int, header: _Header, size: int) -> int:
    """Length of the parameter section: up to the data, else as declared (up to 255 blocks)."""
    data = (header.data_block - 1) * BLOCK
    end = data if data > start else start + max(n_blocks, 1) * BLOCK
    return min(end, size) - start


def _structure(
    path: Path,
    size: int,
    start: int,
    n_blocks: int,
    header: _Header,
    parameters: Parameters,
    accept_truncated: bool,
) -> Structure:
    """Bring header and parameters together; refuse where they contradict each other."""
    notes = []
    n_points = _number_of_points(header, parameters, path.name)
    scale, is_float = _scale(header, parameters, path.name)
    offset = _data_offset(header, parameters, size, path.name)
    if start < offset < start + n_blocks * BLOCK:
        if not parameters.count("POINT", "DATA_START"):
            inside = f"block {offset // BLOCK + 1} by the header, within the parameters"
            raise Refusal(f"{path.name}: damaged: data at {inside}, and no POINT:DATA_START")
        notes.append("the parameter section is declared longer than up to the data")
    section = _section(path, offset, _data_end(parameters, offset, start, size))
    declared = declared_counts(parameters, header.first, header.last)
    word = 4 if is_float else 2
    analog = [n * word for n in _analog_samples(header, parameters)]
    points = 4 * word * n_points
    frame_bytes, count = choose_frame_size(
        declared, section, points, analog, path.name, accept_truncated
    )
    notes += _check_end(section, count.n * frame_bytes, size, path.name, accept_truncated)
    if frame_bytes != points + analog[0]:
        notes.append(
            "analog samples per frame differ from the header; the file size was used to decide"
        )
    rate, rate_notes = _rate(header, parameters, path.name)
    labels = tuple(parameters.texts("POINT", "LABELS")[:n_points])
    units = parameters.texts("POINT", "UNITS")
    base, trial = count.trial_base, declared.trial
    return Structure(
        path=path,
        labels=complete_labels(labels, n_points),
        unit=read_unit(units, "POINT:UNITS", path.name, of_points=True),
        frame_rate_hz=rate,
        encoding=f"{PROCESSORS[header.processor]} {'float' if is_float else 'int16'}",
        notes=(*notes, *count.notes, *rate_notes),
        given_labels=labels,
        listed=_label_texts(parameters),
        missing=tuple(name for name in ("SCALE", "FRAMES") if not parameters.get("POINT", name)),
        n_points=n_points,
        n_frames=count.n,
        frame_count_source=count.source,
        scale=scale,
        first_frame=trial.first(base) if trial and base else header.first,
        processor=header.processor,
        is_float=is_float,
        data_offset=offset,
        frame_bytes=frame_bytes,
        header_first=header.first,
        header_last=header.last,
        trial=trial if base else None,
        trial_base=base,
    )


def _label_texts(parameters: Parameters) -> frozenset[str]:
    names = (n for n in parameters.names("POINT") if not n.startswith(("LABELS", "DESCRIPTIONS")))
    return frozenset(text for name in names for text in parameters.texts("POINT", name))


def _number_of_points(header: _Header, parameters: Parameters, file: str) -> int:
    if len(parameters) == 0:
        raise Refusal(f"{file}: has no parameters, expected at least POINT:USED and POINT:LABELS")
    used = parameters.count("POINT", "USED")
    if used is None:
        raise Refusal(f"{file}: has no POINT:USED, so the number of points is unknown")
    if used != header.n_points:
        raise Refusal(
            f"{file}: damaged: {header.n_points} points by the header, {used} by POINT:USED"
        )
    if used == 0:
        raise Refusal(f"{file}: has no points (analog data only), expected marker trajectories")
    return used


def _scale(header: _Header, parameters: Parameters, file: str) -> tuple[float, bool]:
    """|scale| and whether coordinates are floats (negative scale); an int16 step must be sure."""
    scale = parameters.number("POINT", "SCALE")
    if scale is None:
        scale = header.scale
    if not math.isfinite(scale) or scale == 0:
        raise Refusal(f"{file}: damaged: POINT:SCALE is {scale:g}, expected a number other than 0")
    same = (scale < 0) == (header.scale < 0)
    if scale > 0:
        same = same and math.isclose(scale, header.scale, rel_tol=1e-6)
    if not same:
        said = f"{header.scale:g} by the header, {scale:g} by POINT:SCALE"
        raise Refusal(f"{file}: damaged: scale {said}")
    return abs(scale), scale < 0


def _data_offset(header: _Header, parameters: Parameters, size: int, file: str) -> int:
    declared = parameters.count("POINT", "DATA_START") or header.data_block
    block = header.data_block or declared
    if declared != block:
        raise Refusal(
            f"{file}: damaged: data at block {block} by the header, {declared} by POINT:DATA_START"
        )
    if block < 2 or (block - 1) * BLOCK >= size:
        raise Refusal(
            f"{file}: damaged or cut off: data should be at block {block},"
            f" the file has {size // BLOCK} blocks of {BLOCK} bytes"
        )
    return (block - 1) * BLOCK


def _data_end(parameters: Parameters, offset: int, start: int, size: int) -> int:
    """End of the point data: of the file, or where parameters or rotations follow it."""
    ends = [size]
    if start > offset:
        ends.append(start)
    if parameters.count("ROTATION", "USED"):
        rotations = ((parameters.count("ROTATION", "DATA_START") or 0) - 1) * BLOCK
        if rotations > offset:
            ends.append(rotations)
    return min(ends)


def _section(path: Path, offset: int, end: int) -> Section:
    zeros, at = 0, end
    with path.open("rb") as stream:
        while at > offset and zeros == end - at:
            begin = max(offset, at - BLOCK)
            stream.seek(begin)
            block = stream.read(at - begin)
            zeros += len(block) - len(block.rstrip(b"\0"))
            at = begin
    return Section(end - offset, zeros, end % BLOCK == 0)


def _check_end(
    section: Section, used: int, size: int, file: str, accept_truncated: bool
) -> list[str]:
    """Refuse a file that ends neither on a block nor after its last frame; what to say of it where
    it is accepted. A transfer as text changes line ends, and with them all that follows."""
    if section.on_block or section.available == used:
        return []
    why = (
        f"it ends {size % BLOCK} bytes into a block and not after its last frame: bytes were lost"
        " or added, as by a transfer as text"
    )
    if not accept_truncated:
        raise Truncated(f"{file}: damaged: {why}")
    return [f"{why}; used as it is"]


def _analog_samples(header: _Header, parameters: Parameters) -> list[int]:
    """Possible numbers of analog samples per frame, the header's first."""
    channels = parameters.count("ANALOG", "USED") or 0
    possible = [header.analog_samples, channels * header.samples_per_channel]
    analog = parameters.number("ANALOG", "RATE")
    points = parameters.number("POINT", "RATE") or header.rate
    if analog and points and 1 <= analog / points < 65536:
        possible.append(channels * round(analog / points))
    return possible


def _rate(header: _Header, parameters: Parameters, file: str) -> tuple[float, tuple[str, ...]]:
    """Frame rate in Hz, the shortest decimal of its float32; 0 where there is none."""
    told = parameters.numbers("POINT", "RATE")
    sources = {"POINT:RATE": float(told[0]) if len(told) else 0.0, "the header": header.rate}
    rates = {
        source: float(str(np.float32(rate)))
        for source, rate in sources.items()
        if math.isfinite(rate) and rate > 0
    }
    notes = [
        f"the frame rate by {source} is {rate:g} Hz, which is none"
        for source, rate in sources.items()
        if rate and source not in rates
    ]
    if not rates:
        return 0.0, ("the file has no frame rate", *notes)
    rate, *others = rates.values()
    if others and not math.isclose(rate, others[0], rel_tol=1e-3):
        said = ", ".join(f"{rate:g} Hz by {source}" for source, rate in rates.items())
        raise Refusal(f"{file}: frame rates disagree: {said}")
    if others and not math.isclose(rate, others[0], rel_tol=1e-6):
        notes.append(f"frame rate {rate:g} Hz, in the header {others[0]:.7g} Hz")
    return rate, tuple(notes)
