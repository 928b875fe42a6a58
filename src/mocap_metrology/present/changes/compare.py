"""What changed between recordings: captions, sentences and the text of `<group>_compare`."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mocap_metrology.noise.changes.rows import COARSE
from mocap_metrology.present.tables import Row, aligned
from mocap_metrology.present.text import captions

SENTENCES = captions.texts("COMPARE_SENTENCES")


def sentences(rows: Sequence[Row]) -> list[str]:
    """A sentence a comparison: what became better, worse, by how much at most, or nothing."""
    pairs: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        pairs.setdefault((row["recording"], row["reference"]), []).append(row)
    return [f"{new} compared with {old}: {_changes(own)}." for (new, old), own in pairs.items()]


def _changes(rows: Sequence[Row]) -> str:
    parts = []
    for word in ("worse", "better"):
        changed = [row for row in rows if row["word"] == word]
        if changed:
            most = max(changed, key=lambda row: abs(math.log(row["ratio"])))
            parts.append(SENTENCES["change"].format(**(most | {"where": _where(changed)})))
    limited = {row["series"]: row["step_mm"] for row in rows if row["word"] == COARSE}
    if limited:
        step, names = max(limited.values()), ", ".join(limited)
        parts.append(SENTENCES["resolution"].format(names=names, step=step))
    return "; ".join(parts) or SENTENCES["none"]


def _where(changed: Sequence[Row]) -> str:
    """`in x1, L over 0.1 to 1 s and in z1 at 10 s`: successive times of the same series as one."""
    spans: list[tuple[str, list[float]]] = []
    for tau in sorted({row["tau_s"] for row in changed}):
        names = ", ".join(row["series"] for row in changed if row["tau_s"] == tau)
        if not spans or spans[-1][0] != names:
            spans.append((names, []))
        spans[-1][1].append(tau)
    return " and ".join(
        f"in {names} " + (f"over {t[0]:.2g} to {t[-1]:.2g} s" if t[1:] else f"at {t[0]:.2g} s")
        for names, t in spans
    )


def compare_markdown(rows: Sequence[Row], title: str, caption: str) -> str:
    """Title, a sentence a comparison, and a line a series with its ratios side by side."""
    taus = sorted({float(row["tau_s"]) for row in rows})
    lines: dict[tuple[str, ...], dict[float, str]] = {}
    for row in rows:
        key = tuple(row[k] for k in ("recording", "reference", "series", "overall"))
        mark = {"better": " −", "worse": " +"}.get(row["word"], "")
        text = f"{row['ratio']:.3g} ({row['lower']:.3g} to {row['upper']:.3g}){mark}"
        lines.setdefault(key, {})[float(row["tau_s"])] = text
    head = ["recording", "reference", "series", "word", *(f"{tau:.3g} s" for tau in taus)]
    body = [[*key, *(cells.get(tau, "") for tau in taus)] for key, cells in lines.items()]
    told = "\n".join(f"* {sentence}" for sentence in sentences(rows))
    table = "\n".join(aligned([head, *body]))
    return f"# {title}\n\n{caption} `+` worse, `−` better.\n\n{told}\n\n{table}\n"
