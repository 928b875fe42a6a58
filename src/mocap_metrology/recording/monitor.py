"""A facility over its takes: each take in a few numbers, then the chart of all."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.accuracy.monitor_row import Row
from mocap_metrology.accuracy.monitor_take import COLUMNS, Take, numbers, stretches, table
from mocap_metrology.common.files import read_json, write_csv, write_json
from mocap_metrology.noise.series import pair_name, position
from mocap_metrology.present import monitors
from mocap_metrology.present.plot.figure import Texts, save_png
from mocap_metrology.present.text.sentence import render
from mocap_metrology.recording.results import Results
from mocap_metrology.settings import Settings

TAKE = "monitor_take.json"
LEAST_SEEN = 0.5  # of the frames
STEPS, LEAST_COMMON = 4096, 500  # of a take that are kept; that two takes have in common, at least
BY_CHANCE = 4.0  # standard deviations of times in common; beyond it takes are compared as a whole
REPEATED, NEAR = 10.0, 16  # standard deviations of a correlation; steps within which it is alike
EXCHANGED = 0.1  # of the way from where a marker stood itself: it is where another one stood


def write_take(results: Results, settings: Settings) -> Mapping[str, Any]:
    """monitor_take.json of a cleaned recording: its numbers, names and checksums of its files,
    whether it moves, in what share of the frames each marker was seen."""
    clean = results.clean
    origin, series = clean.origin, clean.coordinates
    labels, pairs = origin["labels"], clean.pairs
    positions = {label: position(series, k) for k, label in enumerate(labels, start=1)}
    take_numbers = numbers(
        positions,
        {
            "-".join(labels[k - 1] for k in pair): series[pair_name(pair, pairs)].astype(float)
            for pair in pairs
        },
        origin["frame_rate_hz"],
        settings.monitor.wander_s,
    )
    sums = [segment["sha256"] for segment in origin["segments"]] if not origin["twin"] else []
    document = {
        "recording": origin["recording"],
        "source": origin["source"],
        "files": sorted(segment["path"] for segment in origin["segments"]),
        "sha256": sums,
        "wander_s": settings.monitor.wander_s,
        "moving": bool(results.check.get("moving")),
        "seen": {k: float(np.isfinite(xyz).all(axis=0).mean()) for k, xyz in positions.items()},
        "steps": steps_of(positions.values()),
        "take": asdict(take_numbers),
    }
    write_json(results.folder / TAKE, document)
    return read_take(results.folder)


def steps_of(positions: Iterable[np.ndarray]) -> str:
    """Sizes of the first STEPS steps from frame to frame of all markers together, as ranks of a
    byte in hexadecimal; neither units, axes nor the rounding of an export alter them much."""
    from scipy.stats import rankdata

    every = np.vstack([*positions])[:, : STEPS + 1].astype(np.float64)
    sizes = np.nansum(np.diff(every) ** 2, axis=0)
    return np.uint8(256 * (rankdata(sizes) - 0.5) / max(sizes.size, 1)).tobytes().hex()


def read_take(folder: str | Path) -> Mapping[str, Any]:
    """Contents of monitor_take.json of a recording."""
    return dict(read_json(f"{folder}/{TAKE}"))


def monitor(
    name: str,
    rows: Sequence[Row],
    takes: Mapping[str, Mapping[str, Any]],
    settings: Settings,
    folder: Path,
) -> Mapping[str, Any]:
    """monitor.json, monitor.csv, chart.png of a facility; returns the contents of the first.

    rows: of the sheet, in order; takes: contents of monitor_take.json by recording, of those that
    were accepted. A take that moves is left out, and one that is an earlier one once more.
    """
    used: list[Row] = []
    left_out: dict[str, str] = {}
    first: dict[tuple[str, ...], str] = {}
    noises = Noises(takes)
    begins = False  # a baseline, with a take that cannot be used
    for row in rows:
        why = "it has no results: its recording was refused, or its files are missing"
        if row.recording in takes:
            why = unfit(takes[row.recording], first) or noises.repeated(row.recording)
            if used and row.baseline != "restart" and settings.monitor.frame == "fixed":
                why = why or exchanged(*(takes[of.recording]["take"] for of in (used[-1], row)))
        if why:
            left_out[row.recording] = why
            begins |= row.baseline == "restart"
        else:
            used.append(replace(row, baseline="restart") if begins else row)
            noises.used.append(row.recording)
            begins = False
    of = [takes[row.recording] for row in used]
    judged = stretches(used, [Take(**one["take"]) for one in of], settings.monitor)
    rows_of_table = table(used, judged)
    sources, markers = [one["source"] for one in of], [*of[-1]["take"]["places_mm"]] if of else []
    document = monitors.document(name, used, judged, left_out, sources, markers)
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(folder / "monitor.csv", rows_of_table, COLUMNS)
    n, said = len(used), document["word"] or "no word"
    dates = {"first": used[0].date[:10], "last": used[-1].date[:10]} if used else {}
    title = render("monitor.title", name=name, word=said, n=n, **dates)
    texts = Texts(title, render("monitor.source", **document))
    save_png(monitors.chart(rows_of_table, texts), folder / "chart.png")
    write_json(folder / "monitor.json", document)
    return document


def exchanged(before: Mapping[str, Any], take: Mapping[str, Any]) -> str:
    """Which markers stand where others stood in the take before, or nothing: neither the mean place
    nor a length shows that."""
    from scipy.optimize import linear_sum_assignment
    from scipy.spatial.distance import cdist

    apart = cdist(*(np.array([*one["places_mm"].values()], float) for one in (take, before)))
    if not np.isfinite(apart).all():  # a marker that was not seen
        return ""
    ours, others = linear_sum_assignment(apart)
    ours, others = ours[ours != others], others[ours != others]
    if not apart[ours, others].sum() < EXCHANGED * apart[ours, ours].sum():
        return ""
    labels = np.array([*take["places_mm"]])
    here, there = (", ".join(labels[at]) for at in (ours, others))
    return (
        f"{here} stand where {there} stood in the take before; expected the same labels, and the "
        "object as it stood (a new baseline: restart)"
    )


def times_between(steps: str) -> np.ndarray:
    """Bits (STEPS / 64,) of the times in frames between the largest of `steps_of`, which a part of
    a take has, too, whichever frame it begins with."""
    ranks, bits = np.frombuffer(bytes.fromhex(steps), np.uint8), np.zeros(STEPS, np.uint8)
    if ranks.size >= LEAST_COMMON:
        largest = int(np.sqrt(ranks.size) / 2)
        at = np.sort(np.argpartition(ranks, -largest)[-largest:])
        bits[(at - at[:, None])[np.triu_indices(largest, 1)]] = 1
    return np.packbits(bits).view(np.uint64)


class Noises:
    """Noise of the takes of a monitor, by which one that is exported once more is known; `used`:
    names of those that were accepted."""

    def __init__(self, takes: Mapping[str, Mapping[str, Any]]) -> None:
        self.used: list[str] = []
        self.at = {name: k for k, name in enumerate(takes)}
        self.steps = [str(take.get("steps", "")) for take in takes.values()]
        times = [times_between(one) for one in self.steps]
        self.times = np.array(times, np.uint64).reshape(-1, STEPS // 64)
        self.counts = np.bitwise_count(self.times).sum(axis=1, dtype=float)
        places = [take["take"]["places_mm"] for take in takes.values()]
        kinds = {labels: k for k, labels in enumerate({tuple(one) for one in places})}
        self.kinds = np.array([kinds[tuple(one)] for one in places])
        self.places = np.full((len(places), 3 * max(map(len, places), default=0)), np.nan)
        for row, one in zip(self.places, places, strict=True):
            row[: 3 * len(one)] = np.ravel([*one.values()])

    def repeated(self, name: str) -> str:
        """Whether a take is one that was used, exported once more: why it cannot be used."""
        own, earlier = self.at[name], np.array([self.at[one] for one in self.used], int)
        among = [*self._alike(own, earlier), *self._nearest(own, earlier)]
        for k in among:
            if same_noise(self.steps[own], self.steps[k]):
                return f"it is {[*self.at][k]} exported once more, with the same noise"
        return ""

    def _alike(self, own: int, earlier: np.ndarray) -> np.ndarray:
        """Those with more times in common than by chance: of times within a span whose density
        falls linearly, 4/3 of the product over the span."""
        there = self.times[earlier]
        span = 64 * (there.any(axis=0) & (self.times[own] > 0)).sum()
        chance = 4 / 3 * self.counts[own] * self.counts[earlier] / max(span, 1)
        common = np.bitwise_count(there & self.times[own]).sum(axis=1)
        return earlier[common > chance + BY_CHANCE * np.sqrt(chance)]

    def _nearest(self, own: int, earlier: np.ndarray) -> np.ndarray:
        """The one whose markers stood nearest, if any has them all: an export in steps beyond the
        noise has few of the times in common, but the same mean places."""
        earlier = earlier[self.kinds[earlier] == self.kinds[own]]
        apart = np.nansum(np.abs(self.places[earlier] - self.places[own]), axis=1)
        return earlier[apart.argmin(keepdims=True)] if earlier.size else earlier


def same_noise(own: str, there: str) -> bool:
    """Whether two takes are exports of one, or of parts of it: the correlation of their `steps_of`,
    at the offset where it is surest, is larger by REPEATED of its standard deviations by chance
    than at any other one that is not near, as that of lines and bursts is not."""
    from scipy.signal import correlate

    ranks = [np.frombuffer(bytes.fromhex(one), np.uint8).astype(float) for one in (own, there)]
    if min(map(len, ranks)) < LEAST_COMMON:
        return False
    a, b = ((one - one.mean()) / max(one.std(), 1e-12) for one in ranks)
    product = correlate(a, b, method="fft")
    offset = np.arange(product.size) - (b.size - 1)
    common = np.minimum(a.size, offset + b.size) - np.maximum(offset, 0)
    sure = np.where(common < LEAST_COMMON, 0.0, product / np.sqrt(np.maximum(common, 1)))
    best = int(np.argmax(sure))
    others = np.abs(offset - offset[best]) > NEAR
    return bool(sure[best] > sure[others].max() + REPEATED)


def unfit(take: Mapping[str, Any], first: dict[tuple[str, ...], str]) -> str:
    """Why a take cannot be used, or nothing; first: recording of the checksums and numbers
    that were seen, to which its own are added."""
    if take["moving"]:
        return "its markers move; expected the same object at rest in the same place"
    seen = take.get("seen") or {"": 1.0}
    least = min(seen, key=lambda label: seen[label])
    if seen[least] < LEAST_SEEN:
        share = f"{100 * seen[least]:.0f} %"
        return f"{least} is seen in {share} of the frames; expected half of them or more"
    told = take.get("take", {"jitters_mm": {}, "places_mm": {}})
    if stuck := [label for label, jitter in told["jitters_mm"].items() if jitter == 0]:
        return f"no value of {', '.join(stuck)} changes from frame to frame; expected measured ones"
    places = tuple(f"{value:.6f}" for xyz in told["places_mm"].values() for value in xyz)
    same = {"it is the same file as": tuple(take["sha256"]), "it has the very places of": places}
    for why, key in same.items():
        known = first.setdefault(key, take["recording"]) if key else take["recording"]
        if known != take["recording"]:
            return f"{why} {known}"
    return ""
