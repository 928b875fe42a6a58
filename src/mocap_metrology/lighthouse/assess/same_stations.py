"""Which stations of several recordings are the same: by id, by channel where that is unknown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.assess.reference import check_same_ids
from mocap_metrology.lighthouse.records import MASTER, SLAVE, Station


def same_stations(
    every: Mapping[str, Sequence[Station]],
) -> tuple[list[Station], dict[str, list[int]]]:
    """Stations of all recordings, with what any recording tells of them, and the places in this
    list of those of each.

    Of the first generation master and slave. Of the second by rising channel, that of the first
    recording that has the station. Raises `Refusal` where the recordings are of other stations or
    of both generations, or where a channel is of two stations.
    """
    if len({one.generation for own in every.values() for one in own}) > 1:
        raise Refusal("recordings of stations of both generations; expected those of one")
    first, *others = every
    if every[first][0].generation == 1:
        for name in others:
            theirs, its = ((own[MASTER].id, own[SLAVE].id) for own in (every[name], every[first]))
            check_same_ids(theirs, its, name, first)
        both = [_best([own[k] for own in every.values()]) for k in (MASTER, SLAVE)]
        return both, {name: [MASTER, SLAVE] for name in every}
    found = _of_channels(every)
    order = sorted(range(len(found)), key=lambda k: found[k][0].channel or 0)
    places = {}
    for name, own in every.items():
        rank = [next(k for k, same in enumerate(found) if one in _ids(same)) for one in _ids(own)]
        places[name] = [order.index(k) for k in rank]
        if len(set(places[name])) < len(own):
            raise Refusal(f"{name}: two of its stations are one in the other recordings")
    return [_best(found[k]) for k in order], places


def _of_channels(every: Mapping[str, Sequence[Station]]) -> list[list[Station]]:
    """Stations of the second generation as each recording tells them, those that are one together;
    the first of these names it."""
    found: list[list[Station]] = []
    told = [(name, one) for name, own in every.items() for one in own]
    named: dict[int | None, str] = {}
    for name, one in sorted(told, key=lambda pair: pair[1].id is None):
        if one.id is None:
            same = [own for own in found if any(one.channel == other.channel for other in own)]
        else:
            same = [own for own in found if own[0].id == one.id]
        if len(same) > 1:
            ids = " and ".join(str(own[0].id) for own in same)
            raise Refusal(f"{name}: station {one.role} has no id, and {ids} have that channel")
        if same:
            same[0].append(one)
            continue
        if one.channel in named:
            other = next(own[0].id for own in found if own[0].channel == one.channel)
            raise Refusal(
                f"station {one.role} is {one.id} in {name} and {other} in {named[one.channel]};"
                " expected one station a channel"
            )
        found.append([one])
        named[one.channel] = name
    return found


def _ids(stations: Sequence[Station]) -> list[int]:
    """By which these very entries are told from equal ones."""
    return [id(one) for one in stations]


def _best(told: Sequence[Station]) -> Station:
    """A station as one recording tells it, with factory values if any does, named as by the first;
    its id, too, where another one tells it."""
    best = next((one for one in told if one.factory is not None), told[0])
    uid = next((one.id for one in told if one.id is not None), None)
    return replace(best, role=told[0].role, channel=told[0].channel, id=best.id or uid)
