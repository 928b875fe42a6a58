"""How precise an optical tracking system is, from the recordings it makes.

The names of `mocap_metrology.face` are here, too, imported when they are first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mocap_metrology.face import *  # noqa: F403

NAMES = (
    *("Recording", "Refusal", "Settings", "allan", "calibrate", "check", "clean", "compare"),
    *("labels", "noise", "read", "series", "simulate"),
)


def __getattr__(name: str) -> Any:
    if name not in NAMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from mocap_metrology import face

    return getattr(face, name)


def __dir__() -> list[str]:
    return sorted(NAMES)
