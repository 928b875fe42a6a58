"""Claims that one recording cannot decide: held against many realisations of its twins.

Standard deviations and covariances of nine hours are mostly random walk. Another recording of the
same system may show the contrary, so what a claim is worth is the share of recordings in which it
holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mocap_metrology.noise.gaussian.moments import Cleaning
from mocap_metrology.noise.twins.twin import Twin
from mocap_metrology.present.claims.claim import DOES_NOT, HOLDS, UNKNOWN, Claim, Finding, unknown
from mocap_metrology.present.claims.study import Drawn, Key
from mocap_metrology.present.skurowski.gaussian_table import realisations

REPEATS = 200
SURE = 0.95
ENOUGH = 0.5  # share of realisations that must decide
SLOW_SAMPLES = 1 << 12  # every eight seconds of nine hours: moments need no more


def draw(
    twins: Mapping[Key, Twin], cleaning: Cleaning | None = None, repeats: int = REPEATS
) -> list[Drawn]:
    """`repeats` realisations of the moments of all twins, as the outlier filter leaves them."""
    found = {
        key: realisations(twin, repeats, cleaning, SLOW_SAMPLES) for key, twin in twins.items()
    }
    return [
        Drawn({key: {name: float(v[k]) for name, v in of.items()} for key, of in found.items()})
        for k in range(repeats if found else 0)
    ]


def of_realisations(claim: Claim, found: Finding, draws: Sequence[Drawn]) -> tuple[Finding, str]:
    """The finding with the word that realisations give it, and in how many it holds.

    A realisation that is not precise enough decides nothing. Of those that decide the claim holds
    in 95 % and more (it holds) or in 5 % and fewer (it does not); between them, and where fewer
    than half decide, one recording cannot tell. As found, and no count, where the claim is not by
    chance, or not all of its recordings are twins.
    """
    if not claim.by_chance or not draws:
        return found, ""
    each = [_finding(claim, one) for one in draws]
    if not all(one.there for one in each):
        return found, ""
    words = [one.word for one in each]
    holds, decided = words.count(HOLDS), len(words) - words.count(UNKNOWN)
    word = UNKNOWN
    if decided >= ENOUGH * len(draws):
        if holds >= SURE * decided:
            word = HOLDS
        elif holds <= (1 - SURE) * decided:
            word = DOES_NOT
    counted = f"holds in {holds} of {decided}"
    if decided < len(draws):
        counted += f" that decide, {len(draws)} drawn"
    return Finding(found.value, word), counted


def _finding(claim: Claim, one: Drawn) -> Finding:
    try:
        return claim.find(one)
    except KeyError:
        return unknown("not drawn", there=False)
