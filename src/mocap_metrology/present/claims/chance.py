"""Claims that one recording cannot decide: held against many realisations of its twins.

Standard deviations and covariances of nine hours are mostly random walk. Another recording of the
same system may show the contrary, so what a claim is worth is the share of recordings in which it
holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mocap_metrology.noise.moments import Cleaning
from mocap_metrology.noise.twins import Twin
from mocap_metrology.present.claims.claim import DOES_NOT, HOLDS, UNKNOWN, Claim, Finding
from mocap_metrology.present.claims.study import Drawn, Key
from mocap_metrology.present.skurowski.gaussian_table import realisations

REPEATS = 200
SURE = 0.95
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
    """The finding with the word that realisations give it, and in how many it holds: below 5 % it
    does not, from 95 % on it holds, between them one recording cannot tell.

    As found, and no count, where the claim is not by chance, or not all of its recordings are
    twins.
    """
    if not claim.by_chance or not draws:
        return found, ""
    words = [_word(claim, one) for one in draws]
    if UNKNOWN in words:
        return found, ""
    holds = words.count(HOLDS)
    word = UNKNOWN
    if holds >= SURE * len(draws):
        word = HOLDS
    elif holds <= (1 - SURE) * len(draws):
        word = DOES_NOT
    return Finding(found.value, word), f"holds in {holds} of {len(draws)}"


def _word(claim: Claim, one: Drawn) -> str:
    try:
        return claim.find(one).word
    except KeyError:
        return UNKNOWN
