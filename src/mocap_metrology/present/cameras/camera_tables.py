"""Tables and sentences on the camera subsets of one group."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.noise.cameras.diagnosis import (
    CHANCE_OF_ERROR,
    NAMING_S,
    Addition,
    Diagnosis,
    Estimate,
)
from mocap_metrology.noise.cameras.scaling import Law, law
from mocap_metrology.present.tables import Row

CAPTION = (
    "One row per addition of cameras, marker and averaging time. largest_factor: factor of the "
    "noise (Allan deviation) in the direction (unit vector) in which it rose most or fell least; "
    "mean_factor: geometric mean over all directions; law_factor: the factor expected by S Eq. "
    "3. In least squares, cameras without a fault cannot raise the noise in any direction, and a "
    "single added camera leaves the noise in one direction unchanged. A largest_factor of 1 is "
    "therefore normal. word: raises (largest_factor above 1 + cameras.rise, and above 1 with p < "
    "0.001), falls (mean_factor below 1), same. camera_noise: centroid noise of the noisiest "
    "added camera relative to the median of the cameras (to the earlier ones where only one "
    "addition is known), from frames that the subsets share; without `from`, that of the first "
    "cameras. least_camera_noise: the smallest noise of one camera that can raise the noise this "
    "much. Intervals: 95 %, jackknife over 20 parts of the take."
)
LAW_CAPTION = (
    "S Eq. 3: sigma ~ n^-b with b = 0.5. b: from the Allan deviations at one frame; h_0_b: from "
    "the root of the likelihood estimator's h_0; standard errors from the scatter about the "
    "line; p: probability of such a deviation of b if 0.5 is true. scatter: standard deviation "
    "of ln(n sigma^2), h_0_scatter: of ln(n h_0); in S it is 0.3 to 0.7, because of the "
    "positions of the cameras."
)
LAW_COLUMNS = (
    *("camera_type", "series", "n_subsets", "b", "b_std_error", "b_p", "scatter"),
    *("h_0_b", "h_0_b_std_error", "h_0_b_p", "h_0_scatter"),
)

# Ratio by which a factor must exceed that of another averaging time to be shown in its place
CLEARLY = 1.2


def word(largest: float, p_value: float, mean_upper: float, rise: float) -> str:
    """`raises`, `falls` or `same`."""
    if largest > 1 + rise and p_value < CHANCE_OF_ERROR:
        return "raises"
    return "falls" if mean_upper < 1 else "same"


LARGEST = ("largest_factor", "largest_lower_95", "largest_upper_95")
DIRECTION = ("direction_x", "direction_y", "direction_z")
MEAN = ("mean_factor", "mean_lower_95", "mean_upper_95")
NOISE = ("camera_noise", "camera_noise_lower_95", "camera_noise_upper_95", "camera_noise_p")
COLUMNS = (
    *("camera_type", "from", "to", "n_from", "n_to", "added", "marker", "tau_s", "word"),
    *(*LARGEST, "p_value", *DIRECTION, *MEAN, "law_factor"),
    *("same_frames", *NOISE, "least_camera_noise"),
)


def addition_rows(
    camera_type: str,
    found: Sequence[Addition],
    camera_ids: Mapping[str, Sequence[int | str]],
    labels: Sequence[str],
    diagnosis: Diagnosis,
    rise: float,
) -> list[Row]:
    """Rows of <group>_cameras of one camera type: the first cameras, then the additions."""
    rows = [
        _row(camera_type, "", name, camera_ids[name], camera_ids)
        | {"tau_s": diagnosis.tau_s[0], "same_frames": "yes"}
        | _numbers_of(NOISE, estimate, ())
        for name, estimate in diagnosis.firsts.items()
    ]
    least = diagnosis.least_noise()
    for k, addition in enumerate(found):
        base = _row(camera_type, addition.smaller, addition.larger, addition.added, camera_ids)
        base["same_frames"] = "yes" if diagnosis.together[k] else "no"
        for t, tau in enumerate(diagnosis.tau_s):
            for marker, label in enumerate(labels):
                at = marker, t, k
                row = base | {"marker": label, "tau_s": tau}
                row |= _numbers_of((*LARGEST, "p_value"), diagnosis.largest, at)
                row |= dict(zip(DIRECTION, _upright(diagnosis.direction[at]), strict=True))
                row |= _numbers_of((*MEAN, ""), diagnosis.mean, at)
                row |= _numbers_of(NOISE, diagnosis.noise, (t, k))
                told = row["largest_factor"], row["p_value"], row["mean_upper_95"]
                row["word"] = word(*told, rise)
                row["least_camera_noise"] = least[at] if row["word"] == "raises" else None
                rows.append(row)
    return [{name: row.get(name) for name in COLUMNS} for row in rows]


def _row(
    camera_type: str,
    smaller: str,
    larger: str,
    added: Sequence[int | str],
    camera_ids: Mapping[str, Sequence[int | str]],
) -> Row:
    few, many = len(camera_ids.get(smaller, ())), len(camera_ids[larger])
    return {
        "camera_type": camera_type,
        "from": smaller,
        "to": larger,
        "n_from": few or None,
        "n_to": many,
        "added": ";".join(map(str, added)),
        "law_factor": math.sqrt(few / many) if few else None,
    }


def _numbers_of(names: Sequence[str], estimate: Estimate, at: tuple[int, ...]) -> Row:
    """Factor, lower and upper end of its 95 % interval, p-value, by these names."""
    lower, upper = estimate.interval()
    values = (estimate.factor[at], lower[at], upper[at], estimate.p_value()[at])
    known = math.isfinite(values[0])
    return dict(zip(names, (float(v) if known else None for v in values), strict=True))


def _upright(direction: np.ndarray) -> list[float]:
    """A direction and its opposite are one: the largest component is positive."""
    sign = np.sign(direction[np.abs(direction).argmax()])
    return [float(v) for v in direction * sign]


def law_rows(
    camera_type: str,
    n_cameras: Mapping[str, int],
    sigma_mm: Mapping[str, Mapping[str, float]],
    h_0: Mapping[str, Mapping[str, float]],
) -> list[Row]:
    """Rows of <group>_camera_law: one a series; sigma_mm and h_0 by recording and series."""
    rows = []
    for series in dict.fromkeys(s for values in h_0.values() for s in values):
        numbers = [n_cameras[name] for name in n_cameras]
        of_frame = law(numbers, [sigma_mm[name].get(series, math.nan) for name in n_cameras])
        of_white = law(numbers, [h_0[name].get(series, math.nan) ** 0.5 for name in n_cameras])
        either = of_frame or of_white
        if either:
            count = either.n_subsets
            rows.append(
                {"camera_type": camera_type, "series": series, "n_subsets": count}
                | dict(zip(LAW_COLUMNS[3:7], _numbers(of_frame), strict=True))
                | dict(zip(LAW_COLUMNS[7:], _numbers(of_white), strict=True))
            )
    return rows


def _numbers(found: Law | None) -> tuple[float | None, ...]:
    return (found.b, found.std_error, found.p_value, found.scatter) if found else (None,) * 4


def raised(rows: Sequence[Row]) -> list[Row]:
    """Additions that raised the noise up to 1 s, each with its greatest rise, greatest first."""
    worst: dict[tuple[str, str], Row] = {}
    for row in rows:
        if row["word"] == "raises" and row["tau_s"] <= NAMING_S * 1.01:
            key = row["from"], row["to"]
            old = worst.get(key)
            if old is None or row["largest_factor"] > old["largest_factor"]:
                worst[key] = row
    return sorted(worst.values(), key=lambda row: -row["largest_factor"])


def _more_telling(old: Row | None, new: Row, key: str) -> Row:
    """The greater of two at one averaging time; of two times the first, unless the other is clearly
    greater: as where the noise of a failing camera is correlated."""
    if old is None:
        return new
    ahead = 1.0 if new["tau_s"] == old["tau_s"] else CLEARLY
    return new if new[key] > ahead * old[key] else old


def noisy(rows: Sequence[Row], limit: float) -> list[Row]:
    """Cameras, or sets with one among them, noisier than `limit` times the others, noisiest first.

    A set that holds the ids of a smaller one named is left out: it is noisy because of that.
    """
    worst: dict[str, Row] = {}
    for row in rows:
        value, p = row["camera_noise"], row["camera_noise_p"]
        sure = value is not None and value > limit and p < CHANCE_OF_ERROR
        if sure and row["tau_s"] <= NAMING_S * 1.01:
            worst[row["added"]] = _more_telling(worst.get(row["added"]), row, "camera_noise")
    sets = {added: set(added.split(";")) for added in worst}
    kept = [
        row
        for added, row in worst.items()
        if not any(other < sets[added] for other in sets.values())
    ]
    return sorted(kept, key=lambda row: -row["camera_noise"])


def summary(rows: Sequence[Row], laws: Sequence[Row], settings: Mapping[str, float]) -> Row:
    """What <group>_cameras.json holds: `words`, sentences for a reader; `short`, one a camera type;
    `apart`: whether subsets do not share their frames; `raised` and `noisy`."""
    found, named = raised(rows), noisy(rows, settings["noisy"])
    known = [r["camera_type"] for r in laws if r["b"] is not None]
    words, short = [], []
    for kind in dict.fromkeys([*(row["camera_type"] for row in rows), *known]):
        own, its_named, its_found = (
            [r for r in of if r["camera_type"] == kind] for of in (rows, named, found)
        )
        words += _sentences(kind, own, its_named, its_found, settings) if own else []
        short += [_short(kind, own, its_named, its_found)] if own else []
        words += [law_sentence(laws, kind)] if kind in known else []
    keep = ("camera_type", "from", "to", "added", "marker", "tau_s")
    shown = (*keep, *LARGEST, *DIRECTION, "law_factor")
    return {
        "words": words,
        "short": short,
        "apart": any(row["same_frames"] == "no" for row in rows),
        "raised": [{k: r[k] for k in shown} | {"cause": _cause(r, named)} for r in found],
        "noisy": [{k: r[k] for k in (*keep, *NOISE)} for r in named],
    }


def law_sentence(laws: Sequence[Row], camera_type: str) -> str:
    """`T40: with 7 subsets the noise at one frame falls as n^-b, b = ... (S Eq. 3: 0.5) ...`"""
    own = [r for r in laws if r["camera_type"] == camera_type]
    shown = [r for r in own if r["b"] is not None]
    each = ", ".join(f"{r['series']} {r['b']:.2f} ± {r['b_std_error']:.2f}" for r in shown)
    off = [r["series"] for r in shown if r["b_p"] is not None and r["b_p"] < 0.05]
    verdict = (
        f"significant deviation (5 %): {', '.join(off)}" if off else "no significant deviation"
    )
    white = [r["h_0_scatter"] for r in own if r["h_0_scatter"] is not None]
    scatter = f"; n h_0 scatters by {min(white):.2f} to {max(white):.2f} (ln)" if white else ""
    return (
        f"{camera_type}: noise at one frame falls with the number of cameras as n^-b, expected "
        f"0.5 (S Eq. 3), estimated {each}; {verdict}{scatter}."
    )


def _sentences(
    kind: str,
    rows: Sequence[Row],
    named: Sequence[Row],
    found: Sequence[Row],
    settings: Mapping[str, float],
) -> list[str]:
    """Sentences on one camera type: noisy cameras, increases, and the limits of detection."""
    apart = any(row["same_frames"] == "no" for row in rows)
    frame = min(row["tau_s"] for row in rows)
    words = [_noisy_sentence(row, frame) for row in named]
    by_added = [row for row in found if _cause(row, named) == "added"]
    if by_added:
        words.append(_raised_sentence(by_added, frame, named))
    if len(by_added) < len(found):
        words.append(_earlier_sentence([r for r in found if r not in by_added]))
    if not found:
        words.append(
            f"{kind}: no addition of cameras raised the noise by more than "
            f"{100 * settings['rise']:g} % in any direction."
        )
    if not named and not apart:
        words.append(f"{kind}: no camera is {settings['noisy']:g} times as noisy as the others.")
    if apart:
        words.append(
            f"{kind}: these subsets do not share their frames (simulated one by one, for "
            "instance): a rise shows a noisy camera, whose own noise cannot be estimated."
        )
    return words


def _short(kind: str, rows: Sequence[Row], named: Sequence[Row], found: Sequence[Row]) -> str:
    """The one thing to know of a camera type."""
    if named:
        return (
            f"{kind}: {_ids(named[0])} is {named[0]['camera_noise']:.1f} times as noisy as the "
            "others."
        )
    if not found:
        return f"{kind}: no added camera raised the noise."
    row, frame = found[0], min(row["tau_s"] for row in rows)
    axis = "xyz"[max(range(3), key=lambda k: abs(row[DIRECTION[k]]))]
    ids = row["added"].split(";")
    cameras = f"camera{'' if len(ids) == 1 else 's'} {', '.join(ids)}"
    earlier = "" if _cause(row, named) == "added" else f", because of one of {row['from']}"
    return (
        f"{kind}: adding {cameras} raised the noise most ({row['largest_factor']:.1f} times, "
        f"{row['marker']} {axis}, {_when(row, frame)}){earlier}."
    )


def _cause(row: Row, named: Sequence[Row]) -> str:
    """Whose fault a rise is: `added`, of the cameras added, or `earlier`, of one before them.

    Where frames are shared, a camera known not to be noisy can raise the noise only because least
    squares then gives an earlier, noisy one more weight in that direction.
    """
    ids = {i for other in named for i in other["added"].split(";")}
    own = row["same_frames"] == "no" or not ids.isdisjoint(row["added"].split(";"))
    return "added" if own else "earlier"


def _ids(row: Row) -> str:
    ids = row["added"].split(";")
    return f"camera {ids[0]}" if len(ids) == 1 else f"one of the cameras {', '.join(ids)}"


def _when(row: Row, frame: float) -> str:
    """Averaging time; `frame` is that of one."""
    return "one frame" if row["tau_s"] == frame else f"{row['tau_s']:.2g} s"


def _noisy_sentence(row: Row, frame: float) -> str:
    return (
        f"{row['camera_type']}: {_ids(row)} is {row['camera_noise']:.2f} times as noisy as the "
        f"others (95 %: {row['camera_noise_lower_95']:.2f} to {row['camera_noise_upper_95']:.2f}; "
        f"at {_when(row, frame)})."
    )


def _raised_sentence(found: Sequence[Row], frame: float, named: Sequence[Row]) -> str:
    row, *others = found
    direction = ", ".join(f"{row[name]:.2f}" for name in DIRECTION)
    low, high = row["largest_lower_95"], row["largest_upper_95"]
    text = (
        f"{row['camera_type']}: from {row['n_from']} to {row['n_to']} cameras ({row['added']} "
        f"added) the noise of {row['marker']} rose by a factor of {row['largest_factor']:.2f} "
        f"(95 %: {low:.2f} to {high:.2f}, p < {CHANCE_OF_ERROR:g}) at {_when(row, frame)} along "
        f"({direction}), and by {row['mean_factor']:.2f} on average; the law predicts "
        f"{row['law_factor']:.2f}"
    )
    if row["added"] not in {other["added"] for other in named}:
        text += (
            "; in ordinary least squares, a camera with this effect is at least "
            f"{row['least_camera_noise']:.1f} times as noisy as the others"
        )
    listed = _listed(others)
    return f"{text}. It rose less from {listed}." if listed else f"{text}."


def _earlier_sentence(found: Sequence[Row]) -> str:
    first = min(found, key=lambda row: row["n_from"])
    return (
        f"{first['camera_type']}: cameras that are not noisy themselves raised the noise, from "
        f"{_listed(found)}. This happens if one of the earlier cameras is noisy, here one of "
        f"{first['from']}."
    )


def _listed(rows: Sequence[Row]) -> str:
    return ", ".join(
        f"{r['n_from']} to {r['n_to']} ({r['added']} added) {r['largest_factor']:.2f}" for r in rows
    )
