"""Claims of S that one recording cannot decide, tested on many realisations of its twins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mocap_metrology.noise.gaussian.moments import Cleaning
from mocap_metrology.noise.twins.twin import Twin
from mocap_metrology.papers.gaussian_table import realisations
from mocap_metrology.present.claims.claim import DOES_NOT, HOLDS, UNKNOWN, Claim, Finding
from mocap_metrology.present.claims.study import Drawn, Key

REPEATS = 200
SURE = 0.95
ENOUGH = 0.5  # share of realisations that must decide
SLOW_SAMPLES = 1 << 12  # every eight seconds of nine hours: moments need no more


def draw(
    twins: Mapping[Key, Twin], cleaning: Cleaning | None = None, repeats: int = REPEATS
) -> list[Drawn]:
    """`repeats` realisations of the moments of all twins, after the outlier filter."""
    found = {
        key: realisations(twin, repeats, cleaning, SLOW_SAMPLES) for key, twin in twins.items()
    }
    return [
        Drawn({key: {name: float(v[k]) for name, v in of.items()} for key, of in found.items()})
        for k in range(repeats if found else 0)
    ]


def of_realisations(claim: Claim, found: Finding, draws: Sequence[Drawn]) -> tuple[Finding, str]:
    """The finding with the word that realisations give it, and in how many it holds.

    A realisation that is not precise enough decides nothing. Of those that decide, the claim holds
    in 95 % and more (it holds) or in 5 % and fewer (it does not). It is undecided between these
    shares, and where fewer than half decide. The finding is unchanged and there is no count if the
    claim is not by chance, or if not all of its recordings are twins.
    """
    if not claim.by_chance or not draws:
        return found, ""
    try:
        words = [claim.decide(one).word for one in draws]
    except KeyError:
        return found, ""
    holds, deciding = words.count(HOLDS), len(words) - words.count(UNKNOWN)
    word = UNKNOWN
    if deciding >= ENOUGH * len(draws) and holds >= SURE * deciding:
        word = HOLDS
    elif deciding >= ENOUGH * len(draws) and holds <= (1 - SURE) * deciding:
        word = DOES_NOT
    counted = f"holds in {holds} of {deciding}"
    if deciding < len(draws):
        counted += f" that decide, {len(draws)} drawn"
    return Finding(found.value, word), counted
