"""Stations are known by the id in their flashes: poses of different ones are never compared."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mocap_metrology.common.errors import Refusal

Ids = tuple[int | None, int | None]  # of master and slave, None where unknown


def station_id(given: Any, where: str) -> int | None:
    """Id from a number, a text of one (decimal, or hexadecimal after 0x), or an entry with `id`."""
    if isinstance(given, Mapping):
        given = given.get("id")
    if given is None:
        return None
    try:
        if isinstance(given, (bool, float)):
            raise ValueError
        return int(given, 0) if isinstance(given, str) else int(given)
    except (TypeError, ValueError):
        raise Refusal(f"{where}: id is {given!r}; expected a whole number") from None


def check_same_ids(theirs: Ids, own: Ids, what: str, where: str) -> str:
    """Refuse `what` when its stations are not those of `where`, or have their roles swapped.

    Returns a sentence that says which ids are unknown and so unchecked; empty if both are known.
    """
    swapped = own[::-1]
    if None not in own and own[0] != own[1] and theirs == swapped:
        raise Refusal(
            f"{what}: master and slave are swapped: it names {theirs[0]} as master and {theirs[1]}"
            f" as slave, {where} the other way round; expected the pose of {own[1]} in {own[0]}"
            " (exchange the ids and invert the pose: R^T, -R^T t)"
        )
    for role, its, known in zip(("master", "slave"), theirs, own, strict=True):
        if its is not None and known is not None and its != known:
            raise Refusal(
                f"{what}: its {role} is station {its}, that of {where} is {known};"
                " expected a pose of the same two stations"
            )
    unknown = [
        f"{role} of {source}"
        for source, ids in ((what, theirs), (where, own))
        for role, one in zip(("master", "slave"), ids, strict=True)
        if one is None
    ]
    return f"Station ids not compared: unknown for {', '.join(unknown)}." if unknown else ""
