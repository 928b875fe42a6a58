"""Lighthouse: mirrored poses, last steps that diverge, and variants of the rotor model.

Flights: a deck of four diodes, 30 x 15 mm, level, 8 to 60 s, two stations 4.3 m apart, 2.3 to 5 m
away, factory values of real stations, 53 urad of jitter a sweep and 30 a hit (`flight` of
`benchmarks.lighthouse_recordings`); the variant of the rotor model is given. A board pose is
mirrored if it deviates by more than 20 deg from the truth; a calibration, if more than a tenth of
its poses are. Deep boards: 24 x 16 cm, diodes 20 mm before and behind the plane, and a board file
that is a mirror image. Absurd: a pose that is wrong by more than 100 mm or 2 deg. Variants: rotors
that obey libsurvive's or the Crazyflie's formula in turn, the calibration with its default settings
(at 8b8d0af the Crazyflie's formula). An error is divided by its standard deviation, axis by axis.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from benchmarks.lighthouse_recordings import flight, hand
from benchmarks.poses import calibrated, lengths, off
from benchmarks.rotor_variants import KINDS, judged
from benchmarks.sentences import Row
from mocap_metrology.lighthouse.assess.summary import summary
from mocap_metrology.lighthouse.simulate.recording import SimulatedSweeps

MIRRORED_DEG, MIRRORED_SHARE = 20.0, 0.1
ABSURD = (100.0, 2.0)  # mm, deg
BY_POSES = {"estimators": ("paper-lm",), "variant": "libsurvive"}


def _mirrored(made: SimulatedSweeps, paths: tuple[Any, Any]) -> float:
    """Share of the board poses of both stations that are more than 20 deg from the truth."""
    angles = []
    for path, station in zip(paths, made.twin.stations, strict=True):
        true, _ = made.truth.motion.poses(path.time_s)
        own = np.einsum("ji,njk->nik", station.R, true)
        trace = np.einsum("nij,nij->n", own, path.R)
        angles.append(np.degrees(np.arccos(np.clip((trace - 1) / 2, -1, 1))))
    return float((np.concatenate(angles) > MIRRORED_DEG).mean())


def flights(n: int) -> Iterator[Row]:
    """Decks in flight, the variant of the rotors given."""
    errors, shares, words = [], [], []
    for seed in range(n):
        made = flight(seed)
        found = calibrated(made, **BY_POSES)
        errors.append(lengths(off(made, found.estimates[-1])))
        shares.append(_mirrored(made, found.paths["paper-lm", "factory"]))
        words.append(summary(found, made.truth.stations).verdict.word)
    mm, deg = np.transpose(errors)
    low, middle, high = np.percentile(mm, [5, 50, 95])
    mirrored = sum(share > MIRRORED_SHARE for share in shares)
    case, around = "flights of a deck, 30 x 15 mm", f"{middle:.1f} ({low:.1f}-{high:.1f}) mm"
    yield case, "mirrored calibrations", n, "0", f"{mirrored}"
    yield case, "mirrored board poses, mean", n, "", f"{100 * np.mean(shares):.2f} %"
    yield case, "error, median (5 to 95 %)", n, "<= 2 mm", around
    yield case, "error, median", n, "", f"{np.median(deg):.3f} deg"
    sound = sum(word in ("good", "usable") for word in words)
    yield case, "called good or usable", n, "", f"{sound}"


def deep_boards(n: int) -> Iterator[Row]:
    """A board with depth whose file is its mirror image: nothing can fit."""
    crashes = absurd = failed = 0
    for seed in range(n):
        made = hand(seed, out_of_plane_m=0.02)
        try:
            found = calibrated(made, made.truth.board * [-1, 1, 1], **BY_POSES)
            told = summary(found, made.truth.stations).verdict.word
        except np.linalg.LinAlgError:
            crashes += 1
            continue
        lost = np.greater(lengths(off(made, found.estimates[-1])), ABSURD).any()
        absurd += lost and told != "failed"
        failed += told == "failed"
    case = "file mirrors a board +-20 mm deep"
    yield case, "crashes", n, "0", f"{crashes}"
    yield case, "absurd poses not `failed`", n, "0", f"{absurd}"
    yield case, "`failed`", n, "", f"{failed}"


def variants(n: int, kind: str, case: str) -> Iterator[Row]:
    """Rotors of either sign, nothing said of it."""
    found = [judged(kind, k, ("paper-lm",))[0] for k in range(n)]
    wrong, decided, mm, _, inside = (np.array(column) for column in zip(*found, strict=True))
    yield case, "true variant ruled out", n, "<= 1 %", f"{wrong.sum()}"
    yield case, "other sign ruled out", n, "", f"{decided.sum()}"
    share = f"{100 * inside.mean() / 6:.0f} %"
    yield case, "95 % intervals hold, six axes", n, ">= 95 %", share
    error = f"{np.median(mm):.1f} ({np.percentile(mm, 95):.1f}) mm"
    yield case, "error, median (95 %)", n, "", error


def rows(n: int) -> Iterator[Row]:
    """All cases; flights and variants of n / 2 recordings."""
    half = max(n // 2, 2)
    yield from flights(half)
    yield from deep_boards(half)
    yield from variants(n, KINDS[0], "board of 24 x 16 cm, either sign")
    yield from variants(half, KINDS[1], "flights, either sign")
