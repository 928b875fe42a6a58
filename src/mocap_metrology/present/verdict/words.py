"""The verdict on a recording in words: lines for a terminal, a row of the group's table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from mocap_metrology.noise.assess.checks import COORDINATE, worst
from mocap_metrology.present.tables import Record, Row
from mocap_metrology.present.text.numbers import duration_words, significant, with_unit

MOVES = "still.range_mm"  # the threshold for being at rest
Found = Record  # contents of verdict.json

CAPTION = (
    "One row per recording. word: good, usable or bad. reason: the check that decided. All "
    "numbers are standard uncertainties (one standard deviation). Each of these is of the worst "
    "coordinate: sigma_frame_mm, scatter of single frames within 1 s (sigma_frame_L_mm: of the "
    "distance L); frame_mm, one frame about the mean of the horizon, or of the recording if that "
    "is shorter; mean_T_s_mm, the same for a mean over T s. These are of the coordinate in column "
    "worst: adev_min_mm, the lowest Allan deviation with at least 10 degrees of freedom, at the "
    "averaging time tau_min_s; dominating_noise, the largest share of the square of frame_mm. "
    "reference_for: the smallest uncertainty of a device for which the system is suitable as a "
    "reference, 4 and 10 times the upper end of its own interval (S 2.2). It includes the noise "
    "alone, without scale and distortion of the volume, and is empty where the word is bad. "
    "n_findings: number of warnings of the diagnosis."
)
HEAD = (
    *("recording", "source", "word", "reason", "worst", "sigma_frame_mm", "sigma_frame_L_mm"),
    *("frame_mm", "adev_min_mm", "tau_min_s", "mean_1_s_mm", "mean_10_s_mm", "mean_60_s_mm"),
    *("reference_for_4x_mm", "reference_for_10x_mm", "dominating_noise", "horizon_s", "n_findings"),
)


def summary_row(found: Found) -> Row:
    """A row of <group>_summary: `HEAD`."""
    series = found["series"]
    name = worst_coordinate(_with_numbers(series), "frame_mm")
    own = series.get(name, {})
    means = [_worst_mean(series, k) for k in range(3)]
    return {
        "recording": found["recording"],
        "source": found["source"],
        "word": found["word"],
        "reason": found["reason"],
        "worst": name,
        "sigma_frame_mm": _largest(series, "sigma_frame_mm"),
        "sigma_frame_L_mm": series.get("L", {}).get("sigma_frame_mm"),
        "frame_mm": own.get("frame_mm"),
        "adev_min_mm": own.get("adev_min_mm"),
        "tau_min_s": own.get("tau_min_s"),
        **dict(zip(("mean_1_s_mm", "mean_10_s_mm", "mean_60_s_mm"), means, strict=True)),
        "reference_for_4x_mm": found["reference_for_mm"]["4"],
        "reference_for_10x_mm": found["reference_for_mm"]["10"],
        "dominating_noise": dominating(own) if own else "",
        "horizon_s": found["horizon_s"],
        "n_findings": len(warnings_of(found)),
    }


def dominating(series: Found) -> str:
    """Kind of noise with the largest share of the uncertainty of one frame; empty if unknown."""
    shares: Mapping[str, float] = series["shares"]
    return max(shares, key=lambda name: shares[name], default="")


def worst_coordinate(series: Mapping[str, Found], key: str) -> str:
    """Name of the coordinate with the greatest `key`; empty without one."""
    return worst({k: v[key] for k, v in series.items() if COORDINATE.fullmatch(k)})[0]


def warnings_of(found: Found) -> list[str]:
    """What the diagnosis warns of; what it only remarks stays in its own files."""
    return [item["words"] for item in found["sentences"] if item["severity"] != "info"]


def reference_sentence(found: Found) -> str:
    """S 2.2's rule with this recording's numbers, which are of noise only."""
    four, ten = (found["reference_for_mm"][k] for k in ("4", "10"))
    if four is None or math.isnan(four):
        return "Not suitable as a reference."
    return (
        "By its noise alone, suitable as a reference for devices with an uncertainty of at least "
        f"{with_unit(four, 'mm')} (4 times the upper end of its interval; 10 times: "
        f"{with_unit(ten, 'mm')}). Scale and distortion of the volume are not included."
    )


def marker_numbers(found: Found) -> str:
    """Which marker has which number in the names of series; empty if that is not known."""
    labels = found.get("labels") or []
    said = ", ".join(f"{k} = {label}" for k, label in enumerate(labels, start=1))
    return f"Marker{'s' if len(labels) > 1 else ''}: {said}." if said else ""


def sentences(found: Found) -> list[str]:
    """The reason, the number if it is not in it, what else was found, and what follows."""
    number = found.get("uncertainty") or ""
    said = [found["reason"], *([number] if number else [])]
    return [*said, *(cap["reason"] for cap in found["caps"]), reference_sentence(found)]


def verdict_lines(found: Found) -> list[str]:
    """What `make check` prints of a recording; of one that moves no noise, which would be of the
    movement."""
    horizon = duration_words(found["horizon_s"])
    first = f"{found['recording']}: {found['word']}"
    if found["decided_by"]["threshold"] == MOVES:
        return [first, found["reason"], reference_sentence(found)]
    lines = [
        first,
        *sentences(found),
        *([numbers] if (numbers := marker_numbers(found)) else []),
        "",
        f"Standard uncertainties in mm, about the mean of {horizon}:",
        *_aligned(_table(found["series"])),
    ]
    lines += _measured(found)
    lines += ["", mean_words(found), *_aligned(mean_table(found["series"]))]
    findings = [words for words in _not_stated(found) if not _told(words, found)]
    if findings:
        lines += ["", "Findings:", *(f"  {words}" for words in findings)]
    said = {words.casefold().rstrip(".") for words in findings}
    warnings = [w for w in found["warnings"] if w.casefold().rstrip(".") not in said]
    return [*lines, *(f"warning: {words}" for words in warnings)]


def mean_words(found: Found) -> str:
    """What `mean_table` is of, and what is not in it."""
    return (
        f"Mean of all frames, and the length in s for k u of {found['mean_mm']:g} mm (type A; "
        "k = t(0.975) by the effective degrees of freedom). Not covered: "
        f"{', '.join(found['not_covered'])}."
    )


def mean_table(series: Mapping[str, Found]) -> list[list[str]]:
    """A row a series, with its head; a dash where the mean depends on when it is taken."""
    rows = [["", "u", "k", "k u", "independent frames (95 %)", "T_c", "length needed"]]
    for name, values in series.items():
        one = values["mean_of_all"]
        ends = [significant(one[f"n_eff_{end}_95"]) for end in ("lower", "upper")]
        n_eff = significant(one["n_eff"])
        rows.append(
            [
                name,
                in_mm(one["u_mm"]),
                significant(one["k"]) or "-",
                in_mm(one["expanded_mm"]),
                f"{n_eff} ({ends[0]} to {ends[1]})" if n_eff else "-",
                significant(one["correlation_s"]) or "-",
                significant(one["length_s"]) or "-",
            ]
        )
    return rows


# Kinds of findings that a check of the verdict states as well
STATED = {
    "share of missing frames": ("filled", "gaps"),
    "low-pass filter of the export": ("low_pass",),
    "share of outliers": ("outliers",),
    "step of the file": ("resolution",),
}


def _not_stated(found: Found) -> list[str]:
    """Warnings of the diagnosis without those that are alone of their kind and that the reasons
    of the verdict state already."""
    checks = [found["decided_by"], *found["caps"]]
    stated = [kind for check in checks for kind in STATED.get(check["quantity"], ())]
    warned = [item for item in found["sentences"] if item["severity"] != "info"]
    kinds = [item["kind"] for item in warned]
    return [
        item["words"]
        for item in warned
        if item["kind"] not in stated or kinds.count(item["kind"]) > 1
    ]


def _measured(found: Found) -> list[str]:
    """Which series have measured and no modelled numbers, and why, unless stated elsewhere."""
    reasons: dict[str, list[str]] = {}
    for name, values in found["series"].items():
        if values["why_measured"]:
            reasons.setdefault(values["why_measured"], []).append(name)
    said = " ".join(sentences(found)).casefold()
    if len(reasons) == 1 and all(v["why_measured"] for v in found["series"].values()):
        (why,) = reasons
        return ["", f"All measured, not modelled{'' if why.casefold() in said else f': {why}'}."]
    lines = [f"  {', '.join(names)}: {why}" for why, names in reasons.items()]
    return ["", "Measured, not modelled:", *lines] if lines else []


def _told(finding: str, found: Found) -> bool:
    """Whether it only repeats that, and why, there is no noise model."""
    refused = any(values["status"] == "refused" for values in found["series"].values())
    return refused and finding.startswith("No noise model of ")


# Names of the quantities, in the order of the figure
FRAME, NEAR = "one frame", "one frame within 1 s"
MEANS = ("mean of 1 s", "mean of 10 s", "mean of 60 s")
_HEAD = ["", FRAME, NEAR, *MEANS, "lowest ADEV", "mostly"]


def _table(series: Mapping[str, Found]) -> list[list[str]]:
    rows = [_HEAD, *(_cells(k, v) for k, v in series.items())]
    return rows if any(row[-1] for row in rows[1:]) else [row[:-1] for row in rows]


def _cells(name: str, values: Record) -> list[str]:
    least = in_mm(values["adev_min_mm"])
    falls = ", still falling" if values["adev_still_falls"] else ""
    at = f"{falls} at {significant(values['tau_min_s'])} s" if least != "-" else ""
    means = [in_mm(m["uncertainty_mm"]) for m in values["means"]]
    share = dominating(values)
    mostly = f"{share} {100 * values['shares'][share]:.0f} %" if share else ""
    return [
        name,
        in_mm(values["frame_mm"]),
        in_mm(values["sigma_frame_mm"]),
        *means,
        f"{least}{at}",
        mostly,
    ]


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    width = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return [
        "  " + "  ".join(c.ljust(w) for c, w in zip(row, width, strict=True)).rstrip()
        for row in rows
    ]


def in_mm(value: float | None) -> str:
    """Three digits, or a dash for nothing."""
    return significant(value, least=1e-6) or "-"


def _with_numbers(series: Mapping[str, Found]) -> dict[str, Found]:
    """Those with an uncertainty; JSON has null for none."""
    return {k: v for k, v in series.items() if v["frame_mm"] is not None}


def _largest(series: Mapping[str, Found], key: str) -> float | None:
    own = {k: v for k, v in series.items() if v[key] is not None}
    name = worst_coordinate(own, key)
    return own[name][key] if name else None


def _worst_mean(series: Mapping[str, Found], number: int) -> float | None:
    own = {k: {"u": v["means"][number]["uncertainty_mm"]} for k, v in series.items()}
    return _largest(own, "u")
