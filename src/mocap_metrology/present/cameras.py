"""Captions and sentences on the camera subsets of one group."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
import pandas as pd

from mocap_metrology.common.types import Record
from mocap_metrology.noise.cameras import findings
from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.plot.curves import Limits, log_limits
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text import captions

SENTENCES = captions.texts("CAMERA_SENTENCES")
HEIGHTS_MM, REST_MM = (60.0, 48.0, 46.0), 22.0  # of the rows (a), (b), (c)
PANELS = (  # of a column: letter, title (of the first its camera type), label
    ("a", "", "Allan deviation,\none frame (mm)"),
    ("b", "With each addition", "Noise of subset /\nof the smaller one"),
    ("c", "Each added camera", "Noise of camera /\nmedian of all"),
)
NO_DEVIATION = "no significant deviation"
MOST, NAME = 3, 18  # camera types side by side, characters over a panel
ALARM = "#c2185b"
RAISED: plot.Keywords = {"color": ALARM, "alpha": 0.13, "lw": 0}
LAW: plot.Keywords = {"color": plot.FAINT, "lw": 0.8, "zorder": 0.5}
TAU_LOOKS = (("o", plot.INK), ("s", "#5c5c5c"), ("^", "#757575"))  # one frame, 0.1 s, 1 s
CLOSE = 0.88  # of the next larger number of cameras, from which its label would touch
Rows = Sequence[Row]
Settings = Mapping[str, float]
Levels = Mapping[str, Record]  # of each recording: n, ids it is without, deviation by coordinate
Pairs = Collection[tuple[str, str]]  # recordings: smaller and larger subset


def summary(rows: Rows, laws: Rows, settings: Settings) -> Row:
    """What <group>_cameras.json holds: `words`, sentences for a reader; `short`, one a camera type;
    `apart`: whether subsets do not share their frames; `raised` and `noisy`."""
    rises, loud = findings.raising_additions(rows), findings.noisy(rows, settings["noisy"])
    words, short = [], []
    for kind in dict.fromkeys(row["camera_type"] for row in (*rows, *laws)):
        its_rows, its_rises, its_loud, its_laws = (
            [r for r in of if r["camera_type"] == kind] for of in (rows, rises, loud, laws)
        )
        sentences = _law_sentence(its_laws)
        if its_rows:
            sentences = [*_sentences(its_rows, its_rises, its_loud, settings), *sentences]
            short.append(f"{kind}: {_short_finding(its_rows, its_rises, its_loud)}")
        words += [f"{kind}: {sentence}" for sentence in sentences]
    columns = ("camera_type", "from", "to", "added", "marker", "tau_s")
    of_rise = (*columns, *findings.LARGEST, *findings.DIRECTION, "law_factor")
    return {
        "words": words,
        "short": short,
        "apart": _of_other_frames(rows),
        "raised": [{k: r[k] for k in of_rise} | {"cause": findings.cause(r, loud)} for r in rises],
        "noisy": [{k: r[k] for k in (*columns, *findings.NOISE)} for r in loud],
    }


def _of_other_frames(rows: Rows) -> bool:
    return any(row["same_frames"] == "no" for row in rows)


def _sentences(rows: Rows, rises: Rows, loud: Rows, settings: Settings) -> list[str]:
    """On one camera type: noisy cameras, increases, and what was not detected."""
    apart = _of_other_frames(rows)
    if exchanged := findings.exchanged(rows):
        return [_filled("exchanged", row, rows) for row in exchanged]
    by_earlier = [row for row in rises if findings.cause(row, loud) == "earlier"]
    rest, silent = findings.not_judged(rows), not (loud or apart or by_earlier)
    names = {"none raised": not rises, "none noisy": silent and not rest}
    names |= {"none noisy added": silent and bool(rest), "apart": apart}
    limits = {"rise": 100 * settings["rise"], "noisy": settings["noisy"]}
    listed = ", ".join(row["added"].replace(";", ", ") for row in rest)
    words = [_filled("noisy", row, rows) for row in loud]
    by_added = [row for row in rises if row not in by_earlier]
    if by_added:
        first, *others = by_added
        text = _filled("raised", first, rows)
        if first["added"] not in {row["added"] for row in loud}:
            text += _filled("bound", first, rows)
        words.append(f"{text}." + (f" It rose less from {_listed(others)}." if others else ""))
    if by_earlier:
        smallest = min(by_earlier, key=lambda row: row["n_from"])
        words.append(SENTENCES["earlier"].format(**(smallest | {"listed": _listed(by_earlier)})))
    return words + [
        SENTENCES[name].format(**limits, rest=listed) for name, holds in names.items() if holds
    ]


def _short_finding(rows: Rows, rises: Rows, loud: Rows) -> str:
    """The one thing to know of a camera type."""
    if exchanged := findings.exchanged(rows):
        return _filled("exchanged", exchanged[0], rows)
    if loud:
        return _filled("short noisy", loud[0], rows)
    if not rises:
        return SENTENCES["short none"]
    row = rises[0]
    axis = max("xyz", key=lambda axis: abs(row[f"direction_{axis}"]))
    by_earlier = findings.cause(row, loud) == "earlier"
    earlier = f", which points to one of the cameras of {row['from']}" if by_earlier else ""
    return _filled("short raised", row | {"axis": axis, "earlier": earlier}, rows)


def _filled(name: str, row: Row, rows: Rows) -> str:
    """A sentence with the numbers of one row; rows: all of the camera type."""
    ids = row["added"].split(";")
    listed = ", ".join(ids)
    cameras = f"camera {listed}" if len(ids) == 1 else f"one of the cameras {listed}"
    single = row["tau_s"] == min(other["tau_s"] for other in rows)
    when = "one frame" if single else f"{row['tau_s']:.2g} s"
    texts = {"cameras": cameras, "ids": listed, "plural": "s" * (len(ids) > 1), "when": when}
    return SENTENCES[name].format(**(row | texts))


def _listed(rows: Rows) -> str:
    form = "{n_from} to {n_to} ({added} added) {largest_factor:.2f}"
    return ", ".join(form.format(**row) for row in rows)


def _law_sentence(laws: Rows) -> list[str]:
    known = [row for row in laws if row["b"] is not None]
    if not known:
        return []
    off = [row["series"] for row in known if row["b_p"] is not None and row["b_p"] < 0.05]
    white = [row["h_0_scatter"] for row in laws if row["h_0_scatter"] is not None]
    scatter = f"; n h_0 scatters by {min(white):.2f} to {max(white):.2f} (ln)" if white else ""
    verdict = f"significant deviation (5 %): {', '.join(off)}" if off else NO_DEVIATION
    each = ", ".join(f"{r['series']} {r['b']:.2f} ± {r['b_std_error']:.2f}" for r in known)
    return [SENTENCES["law"].format(each=each, verdict=verdict, scatter=scatter)]


@plot.styled()
def camera_figure(
    rows: Rows, sigma_mm: Mapping[str, Levels], settings: Settings, texts: plot.Texts
) -> plot.Picture:
    """The figure of `captions.CAMERAS`, a column a camera type. rows: of <group>_cameras; sigma_mm:
    by camera type; settings: `rise`, `noisy`."""
    table = pd.DataFrame(rows, columns=findings.COLUMNS)
    changes = findings.worst_marker(table[table["from"] != ""], findings.LARGEST)
    cameras = findings.worst_marker(table[table["tau_s"] == table["tau_s"].min()], findings.NOISE)
    levels = {kind: pd.DataFrame.from_dict(dict(of), "index") for kind, of in sigma_mm.items()}
    limits = log_limits([of.drop(columns=["n", "without"]).to_numpy() for of in levels.values()])
    heights = HEIGHTS_MM if len(cameras) else HEIGHTS_MM[:2]
    n_rows, columns, blocks = len(heights), min(len(levels), MOST), -(-len(levels) // MOST)
    body = plot.new_figure(texts, REST_MM + blocks * sum(heights))
    how: plot.Keywords = {"squeeze": False, "sharey": "row", "height_ratios": heights * blocks}
    grid = body.subplots(blocks * n_rows, columns, **how)
    for k, (kind, of_kind) in enumerate(levels.items()):
        panels = grid[k // MOST * n_rows :, k % MOST][:n_rows]
        of_type = [row for row in rows if row["camera_type"] == kind]
        rises = {(row["from"], row["to"]) for row in findings.raising_additions(of_type)}
        loud = {row["added"] for row in findings.noisy(of_type, settings["noisy"])}
        loud_steps = {(row["from"], row["to"]) for row in of_type if row["added"] in loud}
        _noise_panel(panels[0], of_kind, rises, limits)
        plot.panel_title(panels[0], plot.short(kind, NAME))
        below = (
            (changes, rises, 1 + settings["rise"], "no addition of cameras"),
            (cameras, loud_steps, settings["noisy"], "frames are not shared"),
        )
        for axes, (steps, bad, limit, nothing) in zip(panels[1:], below, strict=False):
            values = steps["value"]
            plot.log_axis(axes, "y", (min([0.8, *(values / 1.12)]), max([1.25, *(values * 1.12)])))
            _factor_panel(axes, steps[steps["camera_type"] == kind], bad, limit, nothing)
            axes.set_xlabel("Ids of the cameras" + " added" * (steps is changes))
    for axes in grid[-n_rows:, (len(levels) - 1) % MOST + 1 :].flat:
        axes.axis("off")
    for k, axes in enumerate(grid[:, 0]):
        letter, title, label = PANELS[k % n_rows]
        plot.panel_title(axes, f"({letter}) {title or axes.get_title(loc='left')}")
        axes.set_ylabel(label)
    grid[1, 0].axvspan(np.nan, np.nan, label="raised or noisy", **RAISED)
    return plot.finished(body, grid.flat, f"{captions.CAMERAS} {texts.caption}", columns=5)


def _noise_panel(axes: plot.Axes, levels: pd.DataFrame, rises: Pairs, limits: Limits) -> None:
    """Against the number of cameras; or, where recordings have equally many, side by side under
    the ids they lack, or their number."""
    levels = levels.sort_values("n", kind="stable")
    nested = levels["n"].is_unique
    x = levels["n"].astype(float) if nested else pd.Series(range(len(levels)), levels.index)
    plot.log_axis(axes, "y", limits)
    axes.grid(visible=False)
    for smaller, larger in sorted(rises):  # a set has another order in each run
        ends = (x[smaller], x[larger]) if nested else (x[smaller] - 0.5, x[smaller] + 0.5)
        axes.axvspan(*ends, **RAISED)
    for name in levels.columns.drop(["n", "without"]):
        if place := plot.coordinate_of(name):
            look = plot.LOOKS[place[0]]
            how = look.line(lw=0.9, label=place[0]) | ({} if nested else {"ls": ""})
            filled = {"markerfacecolor": look.colour} if place[1] == 1 else {}
            axes.plot(x, levels[name], **(how | filled))
    if not nested:
        ids = zip(levels["without"], levels["n"], strict=True)
        texts = ["\n".join(f"−{i}" for i in i) if 0 < len(i) <= 2 else str(n) for i, n in ids]
        plot.name_axis(axes, texts)
        axes.set_xlabel("Cameras left out (−), or their number")
        return
    n = x.to_numpy()
    axes.plot(n, np.outer((n[0] / n) ** 0.5, np.geomspace(*limits, 9)), **LAW)
    axes.plot([], [], label="1/√n (S Eq. 3)", **LAW)
    pad = float(n[-1] / n[0]) ** 0.06
    axes.set(xscale="log", xlim=(n[0] / pad, n[-1] * pad), xlabel="Number of cameras")
    ticks = plot.room_for(n.tolist(), CLOSE)
    axes.set_xticks(ticks, [f"{count:g}" for count in ticks])
    axes.set_xticks([], minor=True)


def _factor_panel(
    axes: plot.Axes, steps: pd.DataFrame, bad: Pairs, limit: float, nothing: str
) -> None:
    """Factors of each addition, at up to three averaging times, with intervals whose ends are wider
    than the points, so that short ones show; the bad ones shaded."""
    if steps.empty:
        axes.set_xticks([])
        plot.write_message(axes, nothing)
        return
    first = steps.drop_duplicates(["from", "to"])
    place = {pair: k for k, pair in enumerate(zip(first["from"], first["to"], strict=True))}
    taus = sorted(steps["tau_s"].unique())[: len(TAU_LOOKS)]
    for j, (tau, (marker, colour)) in enumerate(zip(taus, TAU_LOOKS, strict=False)):
        at_tau = steps[steps["tau_s"] == tau]
        at = np.array([place[pair] for pair in zip(at_tau["from"], at_tau["to"], strict=True)])
        reach = np.nan_to_num(
            [at_tau["value"] - at_tau["lower"], at_tau["upper"] - at_tau["value"]]
        )
        how: plot.Keywords = {"ls": "", "marker": marker, "color": colour, "markersize": 2.6}
        how |= {"elinewidth": 0.9, "capsize": 3.2, "capthick": 0.7}
        how["label"] = f"{tau:.2g} s" if j else "one frame"
        axes.errorbar(at + (j - (len(taus) - 1) / 2) * 0.24, at_tau["value"], yerr=reach, **how)
    axes.axhline(1, color=plot.GREY, lw=0.8)
    axes.axhline(limit, label="limit", color=ALARM, lw=0.9, ls=(0, (4, 2)))
    for pair, at_pair in place.items():
        if pair in bad:
            axes.axvspan(at_pair - 0.5, at_pair + 0.5, **RAISED)
    added = [ids.split(";") for ids in first["added"]]
    few = ("\n".join(map(plot.short, i)) if len(i) <= 2 else f"{len(i)} ids" for i in added)
    plot.name_axis(axes, list(few))
