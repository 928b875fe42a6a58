"""What files of one take must agree in, whatever their format."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from mocap_metrology.common.errors import Refusal, Unseen


class Described(Protocol):
    """What a file says about itself; `frame_rate_hz` 0 where it has none."""

    @property
    def path(self) -> Path: ...
    @property
    def name(self) -> str: ...
    @property
    def labels(self) -> tuple[str, ...]: ...
    @property
    def frame_rate_hz(self) -> float: ...


def check_alike(segments: Sequence[Described]) -> None:
    """Refuse segments that cannot be of one take."""
    first = segments[0]
    for i, other in enumerate(segments[1:], start=1):
        if any(other.path.resolve() == s.path.resolve() for s in segments[:i]):
            raise Refusal(f"{other.name}: is given twice")
        if other.labels != first.labels:
            only = sorted(set(other.labels) ^ set(first.labels))
            what = f"{only[0]!r} is in one of them only" if only else "in another order"
            raise Refusal(f"{other.name}: its labels are not those of {first.name}: {what}")
        rates = first.frame_rate_hz, other.frame_rate_hz
        if not math.isclose(*rates, rel_tol=1e-6):
            raise Refusal(
                f"{other.name}: its frame rate is {rates[1]:g} Hz, that of {first.name}"
                f" {rates[0]:g} Hz"
            )


def frame_rate(first: Described, given: float | None) -> float:
    """Frame rate in Hz: `given`, which may differ from the file's by 0.1 %, else the file's."""
    if given is not None and not (math.isfinite(given) and given > 0):
        raise Refusal(f"{first.name}: frame_rate_hz is {given}, expected a positive number")
    if first.frame_rate_hz == 0:
        if given is None:
            raise Refusal(f"{first.name}: has no frame rate; give it in column frame_rate_hz")
        return float(given)
    if given is None:
        return first.frame_rate_hz
    if not math.isclose(given, first.frame_rate_hz, rel_tol=1e-3):
        raise Refusal(
            f"{first.name}: its frame rate is {first.frame_rate_hz:g} Hz, frame_rate_hz says"
            f" {given:g} Hz; they may differ by 0.1 %"
        )
    return float(given)


def check_seen(
    labels: Sequence[str], n_frames: int, counts: Sequence[dict[str, int]], file: str
) -> None:
    """Refuse a marker that is valid in no frame; `counts` of invalid frames by reason."""
    for label, by_reason in zip(labels, counts, strict=True):
        if sum(by_reason.values()) == n_frames:
            found = [f"{n} {reason.replace('_', ' ')}" for reason, n in by_reason.items() if n]
            raise Unseen(
                f"{file}: marker {label!r} is valid in no frame of {n_frames} ({', '.join(found)})"
            )
