"""Words, table row and picture of a verdict."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from figure_data import check_saved, every_text
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg

from mocap_metrology.noise.assess.recording import Inputs, assess_recording
from mocap_metrology.noise.assess.uncertainty import Span
from mocap_metrology.noise.fit.estimates import correlation_class
from mocap_metrology.present.plot.figure import Picture
from mocap_metrology.present.text.numbers import with_unit
from mocap_metrology.present.verdict.document import verdict_document
from mocap_metrology.present.verdict.figure import KINDS, kind_of, verdict_figure
from mocap_metrology.present.verdict.words import HEAD, in_mm, summary_row, verdict_lines

RATE, N = 50.0, 6000  # 2 min
SIGMA = {"x1": 0.02, "y1": 0.12, "z1": 0.03}


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
    found = verdict_document(assess_recording(inputs, Span(RATE)), "measured")
    found = {"recording": "lab-1", "group": "lab", "twin": None, **found}
    return nulled(found | {"warnings": ["marker A moves"], "sentences": SENTENCES})


def left_of(picture: Picture) -> Axes:
    """The axes with the uncertainties."""
    axes: Axes = picture.figure.axes[0]
    return axes


SENTENCES = [
    {"severity": "warning", "words": "Marker A moves.", "kind": "moving"},
    {"severity": "info", "words": "No event.", "kind": "event"},
]


def nulled(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: nulled(v) for k, v in value.items()}
    if isinstance(value, list):
        return [nulled(v) for v in value]
    return None if isinstance(value, float) and math.isnan(value) else value


def test_row_names_the_worst_coordinate() -> None:
    row = summary_row(contents())
    assert tuple(row) == HEAD
    assert (row["word"], row["worst"], row["source"]) == ("usable", "y1", "measured")
    assert row["frame_mm"] == pytest.approx(0.12, rel=1e-3)
    assert row["mean_1_s_mm"] == pytest.approx(0.12 / math.sqrt(RATE), rel=0.01)
    assert row["reference_for_4x_mm"] == pytest.approx(0.48, rel=0.015)  # by the upper end
    assert (row["dominating_noise"], row["n_findings"]) == ("white", 1)
    assert (row["adev_min_mm"], row["tau_min_s"]) == (0.25, 0.25)
    assert row["sigma_frame_L_mm"] is None


def test_lines_say_word_reason_and_numbers_once() -> None:
    lines = verdict_lines(contents())
    assert lines[0] == "lab-1: usable"
    assert lines[1].startswith("One frame of y1 is uncertain by 0.1200 (0.1179…0.1211) mm about")
    assert lines[1].endswith("; a recording of 2 min gives no information about an hour.")
    assert "1 marker; at least 2 are needed: without a distance" in lines[2]
    four, ten = (with_unit(contents()["reference_for_mm"][k], "mm") for k in ("4", "10"))
    assert lines[3] == (
        "By its noise alone, suitable as a reference for devices with an uncertainty of at least "
        f"{four} (4 times the upper end of its interval; 10 times: {ten}). Scale and distortion "
        "of the volume are not included."
    )
    cells, _ = [re.split(r"\s{2,}", line.strip()) for line in lines if line.startswith("  y1")]
    assert cells[:4] == ["y1", "0.120", "0.120", "0.0169"]
    assert cells[6:] == ["0.250, still falling at 0.250 s", "white 100 %"]
    assert lines.count("  Marker A moves.") == 1
    assert not any(line.startswith("warning") for line in lines)
    assert not any("No event" in line for line in lines)


def test_what_a_reason_states_is_no_finding_again() -> None:
    """Alone of its kind; of several, such as two markers with filled frames, all are listed."""
    cap = {"quantity": "share of missing frames", "reason": "6 % of the frames of x1 are missing."}
    filled = {"severity": "warning", "words": "6 % of A are gap-filled.", "kind": "filled"}
    for count in (1, 2):
        found = contents() | {"caps": [cap], "sentences": [*SENTENCES, *[filled] * count]}
        lines = verdict_lines(found)
        assert lines.count(cap["reason"]) == 1
        assert lines.count(f"  {filled['words']}") == (0 if count == 1 else 2)
        assert "  Marker A moves." in lines


def test_numbers_of_series_are_told_as_markers_in_words_and_picture() -> None:
    found = contents(2) | {"labels": ["RFT1", "Head"]}
    said = "Markers: 1 = RFT1, 2 = Head."
    assert said in verdict_lines(found)
    assert said in verdict_figure(found).caption
    (head,) = [line for line in verdict_lines(found) if "lowest ADEV" in line]
    keys = set(every_text(verdict_figure(found)))
    assert set(re.split(r"\s{2,}", head.strip())[:5]) <= keys


@pytest.mark.parametrize(
    ("value", "words"), [(12345.0, "12300"), (2.5e-5, "0.0000250"), (0.0, "0"), (None, "-")]
)
def test_lengths_have_no_power_of_ten(value: float | None, words: str) -> None:
    assert in_mm(value) == words


def test_reasons_are_said_once_for_all_series() -> None:
    lines = verdict_lines(contents(2, refused=("x1", "x2")))
    assert "  x1, x2: there is no noise model" in lines


def test_without_a_model_the_reason_is_said_once_and_the_number_follows() -> None:
    names = tuple(f"{axis}{k}" for k in (1, 2) for axis in "xyz")
    found = contents(2, refused=names, n=700)
    why = "too short: 700 samples, a noise model needs 1000"
    told = f"No noise model of {', '.join(names)}: 700 valid samples, expected at least 1000."
    found["sentences"] = [{"severity": "warning", "words": told, "kind": "misfit"}, *SENTENCES]
    lines = verdict_lines(found)
    one_frame = next(k for k, line in enumerate(lines) if line.startswith("One frame of y"))
    reference = next(k for k, line in enumerate(lines) if line.startswith("By its noise alone"))
    assert 0 < one_frame < reference and lines[reference + 1].startswith("Markers: ")
    text = "\n".join(lines)
    assert text.count(why) == 1
    assert text.casefold().count("no noise model") == 1
    assert "mostly" not in text
    assert "All measured, not modelled." in lines
    figure = verdict_figure(found)
    said = every_text(figure)
    assert any("One frame of y" in line for line in said)
    assert "Share of the variance of one frame (%)" not in said
    assert figure.caption.count("without a model") == 1


def test_words_above_the_bands_and_arrows_of_a_very_bad_recording() -> None:
    found = contents(2)
    for values in found["series"].values():
        values.update(frame_mm=2e2, frame_lower_mm=1e2, frame_upper_mm=3e2)
    found["series"]["y1"]["frame_upper_mm"] = 3e7
    found["series"]["z1"]["means"][0]["lower_mm"] = 1e-9
    figure = verdict_figure(found | {"word": "bad"})
    left, renderer = left_of(figure), FigureCanvasAgg(figure.figure).get_renderer()
    figure.figure.draw_without_rendering()
    assert [t.get_text() for t in left.texts[:3]] == ["good", "usable", "bad"]
    boxes = [t.get_window_extent(renderer) for t in left.texts[:3]]
    assert boxes[0].x0 >= 0 and boxes[0].x1 < boxes[1].x0 and boxes[1].x1 < boxes[2].x0
    signs = [
        sign
        for line in left.lines
        if (sign := line.get_marker()) in ("<", ">")
        for _ in line.get_xydata()
    ]
    assert "<" in signs and signs.count(">") == 1
    assert "Arrows" in figure.caption


def test_green_points_under_a_worse_word_say_what_decided() -> None:
    found = contents(n_markers=2)
    small = {k: v | {"frame_mm": 0.02} for k, v in found["series"].items()}
    found |= {"series": small, "word": "usable"}
    found["decided_by"] = found["decided_by"] | {"quantity": "duration"}
    figure = verdict_figure(found)
    assert "the bands refer to these alone; the word depends on the duration." in figure.caption
    assert any(text.startswith("Deciding quantity: duration. ") for text in every_text(figure))
    assert not [t for t in left_of(figure).texts if t.get_weight() == "bold"]
    assert "decides the verdict" not in every_text(figure)
    figure = verdict_figure(contents())
    assert "the verdict refers to one frame in the worst coordinate." in figure.caption


def test_the_point_that_decided_is_marked() -> None:
    found = contents()
    left = left_of(verdict_figure(found))
    (ring,) = [line for line in left.lines if line.get_label() == "decides the verdict"]
    name = found["decided_by"]["series"]
    assert ring.get_xdata()[0] == found["series"][name]["frame_mm"]
    assert round(ring.get_ydata()[0]) == list(found["series"]).index(name)


def test_a_recording_without_numbers_has_a_row_and_a_picture(tmp_path: Path) -> None:
    found = contents(empty="y1")
    assert found["series"]["y1"]["frame_mm"] is None
    assert summary_row(found)["worst"] == "z1"
    for series in found["series"].values():
        series.update(frame_mm=None, sigma_frame_mm=None, shares={})
        for mean in series["means"]:
            mean["uncertainty_mm"] = None
    found |= {"reference_for_mm": {"4": None, "10": None}}
    assert summary_row(found)["worst"] == ""
    assert "Not suitable as a reference." in verdict_lines(found)
    check_saved(verdict_figure(found), tmp_path / "none")


def test_what_is_bad_is_no_reference_in_words_either() -> None:
    found = contents(empty="y1") | {"word": "bad", "reference_for_mm": {"4": None, "10": None}}
    assert "Not suitable as a reference." in verdict_lines(found)
    assert summary_row(found)["reference_for_4x_mm"] is None


def test_every_kind_of_noise_has_a_colour() -> None:
    kinds = [
        *("violet", "blue", "white", "flicker", "random walk", "periodic (14.4 Hz)"),
        *("drift", "warm-up", "slow wander"),
        *(f"correlated (T_c {T_c} s)" for T_c in ("0.0417", "1", "9.99", "10.1", "1380")),
    ]
    assert {kind_of(name)[0] for name in kinds} == set(KINDS)
    for T_c in (0.99, 1.0, 9.99, 10.0, 99.9, 100.0, 1380.0):  # as docs and fits have it
        kind, text = kind_of(f"correlated (T_c {T_c:g} s)")
        assert f", {correlation_class(T_c)} (" in kind
        assert text == f"$T_c$ {T_c:g} s"


def test_picture_shows_word_reason_and_all_series(tmp_path: Path) -> None:
    found = contents(2)
    figure = verdict_figure(found)
    texts, left = every_text(figure), left_of(figure)
    assert [t.get_text() for t in left.get_yticklabels()] == list(found["series"])
    assert any("One frame of y" in text for text in texts)
    assert {"good", "usable", "bad"} <= set(texts)
    bold = [t.get_text() for t in left.texts if t.get_weight() == "bold"]
    assert bold == [found["word"]]
    check_saved(figure, tmp_path / "verdict")


def test_many_series_are_cut_to_the_worst() -> None:
    found = contents(12)
    figure = verdict_figure(found)
    shown = [t.get_text() for t in left_of(figure).get_yticklabels()]
    assert len(shown) == 24
    assert {f"y{k}" for k in range(1, 13)} <= set(shown)
    assert "12 series with smaller" in figure.caption


def test_other_checks_stand_beside_their_limits() -> None:
    """The one that decided first; what lowers the word further, and the event; nothing of them
    where the word is good."""
    found = contents(n_markers=2)
    assert left_of(verdict_figure(found)).get_xscale() == "log"
    drift = {"quantity": "drift over the horizon", "series": "z1", "value": 0.4, "limit": 0.346}
    lost = {"quantity": "share of missing frames", "series": "x2", "value": 0.02, "limit": 0.01}
    found |= {
        "word": "usable",
        "decided_by": drift | {"unit": "mm", "threshold": ""},
        "caps": [lost | {"unit": "", "threshold": "", "word": "usable", "reason": "."}],
        "findings": [{"code": "event", "series": "x2", "value": 250.0}],
    }
    above = verdict_figure(found).figure.axes[-1]
    assert [t.get_text() for t in above.texts] == [
        *("drift over the horizon, z1", "0.4, limit 0.346 mm"),
        *("share of missing frames, x2", "2, limit 1 %"),
        *("event at 4 min 10.0 s (x2)", ""),
    ]
    dots = [line.get_xdata()[0] for line in above.lines if line.get_marker() == "D"]
    assert dots == pytest.approx([0.4 / 0.346, 2.0])


def test_mean_of_all_frames_in_words() -> None:
    """Of 10 min of white noise the frames are all independent, the mean has sigma over their root,
    and the length is in proportion to the square of what is wanted."""
    found = contents()
    one = found["series"]["y1"]["mean_of_all"]
    u = SIGMA["y1"] / math.sqrt(N)
    assert one["n_eff"] == pytest.approx(N, rel=1e-3)
    assert one["u_mm"] == pytest.approx(u, rel=1e-3) and one["k"] == pytest.approx(1.96, abs=0.01)
    assert one["length_s"] == pytest.approx(N / RATE * (1.96 * u / 0.01) ** 2, rel=0.01)
    lines = verdict_lines(found)
    at = next(k for k, line in enumerate(lines) if line.startswith("Mean of all frames"))
    assert "scale and distortion of the volume" in lines[at]
    assert [line.split()[0] for line in lines[at + 2 : at + 5]] == ["x1", "y1", "z1"]
    empty = contents(empty="y1")["series"]["y1"]["mean_of_all"]
    assert set(empty.values()) == {None}
