"""A take of a monitored facility as a sheet has it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """recording: its name; date: ISO 8601, with or without a time; baseline: `yes`, `restart` or
    nothing."""

    recording: str
    date: str
    baseline: str = ""
