"""Contents of verdict.json in words, in a row of a table and in a picture."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from figure_data import check_saved, every_text
from matplotlib.axes import Axes

from mocap_metrology.common.parallel import in_turn
from mocap_metrology.noise.assess.recording import Inputs, _unnamed, assess_recording
from mocap_metrology.noise.assess.spread import Share
from mocap_metrology.noise.assess.uncertainty import SeriesNumbers, Span
from mocap_metrology.noise.fit.estimates import correlation_class
from mocap_metrology.present.plot.figure import Picture
from mocap_metrology.present.verdict.figure import CORRELATED, KINDS, verdict_figure
from mocap_metrology.present.verdict.words import (
    mean_table,
    summary_row,
    verdict_document,
    verdict_lines,
)
from mocap_metrology.settings import Verdict as Limits

RATE, N = 50.0, 6000  # 2 min
SIGMA = {"x1": 0.02, "y1": 0.12, "z1": 0.03}
SENTENCES = [
    {"severity": "warning", "words": "Marker A moves.", "kind": "moving"},
    {"severity": "info", "words": "No event.", "kind": "event"},
]


def contents(
    n_markers: int = 1, refused: tuple[str, ...] = (), empty: str = "", n: int = N
) -> dict[str, Any]:
    """verdict.json of white noise, null where there is no number as in the file."""
    rng, series, noise = np.random.default_rng(1), [], []
    for k in range(1, n_markers + 1):
        for axis in "xyz":
            sigma, name = SIGMA[f"{axis}1"], f"{axis}{k}"
            values = sigma * rng.standard_normal(n)
            series.append((name, np.full(n, math.nan) if name == empty else values))
            row = {"series": name, "estimator": "likelihood", "parameter": "h_0"}
            level = {"value": 2 * sigma**2 / RATE, "status": "ok"}
            noise.append(row | (level if name not in refused else {"status": "refused"}))
    columns = ("tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm", "edf")
    curve = {k: np.array([0.5, 0.25]) for k in columns} | {"edf": np.array([40.0, 10.0])}
    allan = {"series": np.array(["y1"] * 2), "estimator": np.array(["oadev"] * 2), **curve}
    inputs = Inputs(series, ["A"] * n_markers, noise, allan, [])
    document = verdict_document(assess_recording(inputs, Span(RATE), Limits(), in_turn), "measured")
    document = {"recording": "lab-1", "group": "lab", "twin": None, **document}
    return nulled(document | {"warnings": ["marker A moves"], "sentences": SENTENCES})


def nulled(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: nulled(v) for k, v in value.items()}
    if isinstance(value, list):
        return [nulled(v) for v in value]
    return None if isinstance(value, float) and math.isnan(value) else value


def left_of(picture: Picture) -> Axes:
    """The axes with the uncertainties."""
    return next(a for a in picture.figure.axes if a.get_xlabel() == "Standard uncertainty (mm)")


def test_row_and_lines_of_white_noise() -> None:
    """Closed forms: a mean over 1 s has 1/sqrt(50) of sigma; a reference needs 4 times better."""
    verdict = contents()
    row = summary_row(verdict)
    assert (row["word"], row["worst"], row["source"]) == ("usable", "y1", "measured")
    sizes = [row["frame_mm"], row["sigma_frame_mm"]]
    assert sizes == pytest.approx([0.12, 0.12], rel=1e-3)
    means = [row[f"mean_{T}_s_mm"] for T in (1, 10, 60)]
    assert means == pytest.approx([0.12 / math.sqrt(T * RATE) for T in (1, 10, 60)], rel=0.5)
    assert means[0] == pytest.approx(0.12 / math.sqrt(RATE), rel=0.01)
    assert row["reference_for_4x_mm"] == pytest.approx(0.48, rel=0.015)  # by the upper end
    assert row["reference_for_10x_mm"] == pytest.approx(2.5 * row["reference_for_4x_mm"])
    assert (row["dominating_noise"], row["n_findings"]) == ("white", 1)
    assert (row["adev_min_mm"], row["tau_min_s"], row["sigma_frame_L_mm"]) == (0.25, 0.25, None)
    lines = verdict_lines(verdict)
    assert lines[0] == "lab-1: usable"
    assert lines[1].startswith("One frame of y1 is uncertain by 0.1200 (0.1179…0.1211) mm about")
    cells, means = [re.split(r"\s{2,}", x.strip()) for x in lines if x.startswith("  y1")]
    assert cells[:4] == ["y1", "0.120", "0.120", "0.0169"]
    assert cells[6:] == ["0.250, still falling at 0.250 s", "white 100 %"]
    assert means == ["y1", *mean_table(verdict["series"])[2][1:]]
    assert lines.count("  Marker A moves.") == 1  # and no warning, which says the same
    assert not any(line.startswith("warning") or "No event" in line for line in lines)
    other = verdict_lines(verdict | {"warnings": ["the unit is assumed"]})
    assert other[-1] == "warning: the unit is assumed"
    moved = verdict | {"decided_by": verdict["decided_by"] | {"code": "moves"}}
    assert len(verdict_lines(moved)) == 3


def test_why_there_is_no_model_is_said_once() -> None:
    assert "  x1, x2: there is no noise model" in verdict_lines(contents(2, refused=("x1", "x2")))
    names = tuple(f"{axis}{k}" for k in (1, 2) for axis in "xyz")
    verdict = contents(2, refused=names, n=700)
    told = f"No noise model of {', '.join(names)}: 700 valid samples, expected at least 1000."
    refusal = {"severity": "warning", "words": told, "kind": "misfit", "series": list(names)}
    verdict["sentences"] = [refusal, *SENTENCES]
    text = "\n".join(verdict_lines(verdict))
    assert text.count("too short: 700 samples, a noise model needs 1000") == 1
    assert text.casefold().count("no noise model") == 1
    assert "\nAll measured, not modelled." in text and "mostly" not in text


def test_picture_shows_word_reason_and_all_series(tmp_path: Path) -> None:
    verdict = contents(2) | {"labels": ["RFT1", "Head"]}
    picture = verdict_figure(verdict)
    texts, left = every_text(picture), left_of(picture)
    assert [t.get_text() for t in left.get_yticklabels()] == list(verdict["series"])
    assert [t.get_text() for t in left.texts if t.get_weight() == "bold"] == [verdict["word"]]
    (ring,) = [line for line in left.lines if line.get_label() == "decides the verdict"]
    name = verdict["decided_by"]["series"]
    assert ring.get_xdata()[0] == verdict["series"][name]["frame_mm"]
    assert round(ring.get_ydata()[0]) == list(verdict["series"]).index(name)
    (frames,) = [line for line in left.lines if line.get_label() == "one frame"]
    assert list(frames.get_xdata()) == [v["frame_mm"] for v in verdict["series"].values()]
    (head,) = [line for line in verdict_lines(verdict) if "lowest ADEV" in line]
    assert set(re.split(r"\s{2,}", head.strip())[:5]) <= set(texts)
    check_saved(picture, tmp_path / "verdict")


def test_of_many_series_the_worst_are_shown_and_the_one_that_decided() -> None:
    """Nine markers have 27 series, z with 0.03 mm and x with 0.02 mm."""
    verdict = contents(9, n=1200)
    verdict["decided_by"] |= {"series": "x3"}
    (note,) = [line for line in verdict_lines(verdict) if "not shown" in line]
    assert note.startswith("3 series with smaller uncertainties")
    picture = verdict_figure(verdict)
    shown = [t.get_text() for t in left_of(picture).get_yticklabels()]
    assert shown == [name for name in verdict["series"] if name in shown] and len(shown) == 24
    assert {"x3"} | {f"{axis}{k}" for axis in "yz" for k in range(1, 10)} < set(shown)
    assert any(note in text.replace("\n", " ") for text in every_text(picture))
    lines = [line for line in verdict_lines(verdict) if line.startswith("  z")]
    assert len(lines) == 2 * 9  # of both tables


def test_kinds_of_noise_are_rows_and_bars() -> None:
    """From fast to slow, each where the one before ends; correlated noise by its class (S 4.6)."""
    numbers = SeriesNumbers("ok", kinds=(Share("random walk", 0.5), Share("drift", 0.25)))
    other = _unnamed(SeriesNumbers("ok", kinds=(*numbers.kinds, Share("white", 0.25))))
    assert other.shares == {"slow wander": 0.75, "white": 0.25}
    kinds = [Share("random walk", 0.4), Share("correlated", 0.3, 1380.0), Share("white", 0.2)]
    kinds += [Share("periodic", 0.1, f_hz=14.4)]
    assert [one.name for one in kinds[1:]] == [
        *("correlated (T_c 1380 s)", "white", "periodic (14.4 Hz)")
    ]
    verdict = contents()
    rows = [{**vars(one), "class": "long" if one.T_c_s > 0 else ""} for one in kinds]
    verdict["series"]["y1"]["kinds"] = nulled(rows)
    picture = verdict_figure(verdict)
    bars = next(a for a in picture.figure.axes if a.get_xlabel().startswith("Share"))
    at_y1 = sorted((p.get_x(), p.get_width()) for p in bars.patches if round(p.get_y()) == 1)
    assert np.ravel(at_y1) == pytest.approx([0.0, 0.2, 0.2, 0.1, 0.3, 0.3, 0.6, 0.4])
    assert "1380 s" in every_text(picture) and "Times in the bars" in picture.caption
    assert {correlation_class(T_c) for T_c in (0.99, 9.99, 10.0, 100.0)} == set(CORRELATED)
    assert set(CORRELATED.values()) < set(KINDS)
