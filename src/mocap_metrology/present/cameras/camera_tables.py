"""Captions and sentences on the camera subsets of one group."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mocap_metrology.noise.cameras.findings import DIRECTION, LARGEST, NOISE, cause, noisy, raised
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text import captions

SENTENCES = captions.texts("CAMERA_SENTENCES")


def summary(rows: Sequence[Row], laws: Sequence[Row], settings: Mapping[str, float]) -> Row:
    """What <group>_cameras.json holds: `words`, sentences for a reader; `short`, one a camera type;
    `apart`: whether subsets do not share their frames; `raised` and `noisy`."""
    rises, loud = raised(rows), noisy(rows, settings["noisy"])
    with_law = [row["camera_type"] for row in laws if row["b"] is not None]
    words, short = [], []
    for kind in dict.fromkeys([*(row["camera_type"] for row in rows), *with_law]):
        own, its_rises, its_loud = (
            [r for r in of if r["camera_type"] == kind] for of in (rows, rises, loud)
        )
        sentences = []
        if own:
            sentences += _sentences(own, its_rises, its_loud, settings)
            short.append(f"{kind}: {_short(own, its_rises, its_loud)}")
        if kind in with_law:
            sentences.append(_law_sentence([r for r in laws if r["camera_type"] == kind]))
        words += [f"{kind}: {sentence}" for sentence in sentences]
    columns = ("camera_type", "from", "to", "added", "marker", "tau_s")
    of_rise = (*columns, *LARGEST, *DIRECTION, "law_factor")
    return {
        "words": words,
        "short": short,
        "apart": _apart(rows),
        "raised": [{k: r[k] for k in of_rise} | {"cause": cause(r, loud)} for r in rises],
        "noisy": [{k: r[k] for k in (*columns, *NOISE)} for r in loud],
    }


def _apart(rows: Sequence[Row]) -> bool:
    return any(row["same_frames"] == "no" for row in rows)


def _sentences(
    rows: Sequence[Row], rises: Sequence[Row], loud: Sequence[Row], settings: Mapping[str, float]
) -> list[str]:
    """On one camera type: noisy cameras, increases, and what was not detected."""
    names = ["none raised"] * (not rises) + ["none noisy"] * (not loud and not _apart(rows))
    names += ["apart"] * _apart(rows)
    limits = {"rise": 100 * settings["rise"], "noisy": settings["noisy"]}
    words = [_filled("noisy", row, rows) for row in loud]
    by_added = [row for row in rises if cause(row, loud) == "added"]
    if by_added:
        first, *others = by_added
        text = _filled("raised", first, rows)
        if first["added"] not in {row["added"] for row in loud}:
            text += _filled("bound", first, rows)
        words.append(f"{text}." + (f" It rose less from {_listed(others)}." if others else ""))
    if by_earlier := [row for row in rises if row not in by_added]:
        smallest = min(by_earlier, key=lambda row: row["n_from"])
        words.append(SENTENCES["earlier"].format(**(smallest | {"listed": _listed(by_earlier)})))
    return words + [SENTENCES[name].format(**limits) for name in names]


def _short(rows: Sequence[Row], rises: Sequence[Row], loud: Sequence[Row]) -> str:
    """The one thing to know of a camera type."""
    if loud:
        return _filled("short noisy", loud[0], rows)
    if not rises:
        return SENTENCES["short none"]
    row = rises[0]
    return _filled(
        "short raised",
        row
        | {"axis": "xyz"[max(range(3), key=lambda k: abs(row[DIRECTION[k]]))]}
        | {"earlier": f", because of one of {row['from']}" * (cause(row, loud) == "earlier")},
        rows,
    )


def _filled(name: str, row: Row, rows: Sequence[Row]) -> str:
    """A sentence with the numbers of one row; rows: all of the camera type."""
    ids = row["added"].split(";")
    listed = ", ".join(ids)
    cameras = f"camera {listed}" if len(ids) == 1 else f"one of the cameras {listed}"
    single = row["tau_s"] == min(other["tau_s"] for other in rows)
    when = "one frame" if single else f"{row['tau_s']:.2g} s"
    texts = {"cameras": cameras, "ids": listed, "plural": "s" * (len(ids) > 1), "when": when}
    return SENTENCES[name].format(**(row | texts))


def _listed(rows: Sequence[Row]) -> str:
    form = "{n_from} to {n_to} ({added} added) {largest_factor:.2f}"
    return ", ".join(form.format(**row) for row in rows)


def _law_sentence(laws: Sequence[Row]) -> str:
    known = [row for row in laws if row["b"] is not None]
    off = [row["series"] for row in known if row["b_p"] is not None and row["b_p"] < 0.05]
    white = [row["h_0_scatter"] for row in laws if row["h_0_scatter"] is not None]
    scatter = f"; n h_0 scatters by {min(white):.2f} to {max(white):.2f} (ln)" if white else ""
    significant = f"significant deviation (5 %): {', '.join(off)}"
    return SENTENCES["law"].format(
        each=", ".join(f"{r['series']} {r['b']:.2f} ± {r['b_std_error']:.2f}" for r in known),
        verdict=significant if off else "no significant deviation",
        scatter=scatter,
    )
