"""Tables, sentences and figure of camera subsets, on simulated systems whose noisy camera is known.

`benchmarks/failing_camera.py` counts over many more.
"""

from __future__ import annotations

import numpy as np
import pytest
from figure_data import ODD_TEXT, check, check_saved, every_text

from benchmarks.failing_camera import wishart_blocks
from mocap_metrology.noise.cameras.diagnosis import N_BLOCKS, Moments, additions, diagnose
from mocap_metrology.noise.twins.take import (
    joint_covariance,
    random_facility,
)
from mocap_metrology.present.cameras.camera_figure import camera_figure
from mocap_metrology.present.cameras.camera_tables import (
    COLUMNS,
    LAW_COLUMNS,
    addition_rows,
    law_rows,
    noisy,
    raised,
    summary,
    word,
)

LIMITS = {"rise": 0.05, "noisy": 1.5}
IDS = tuple(range(11, 21))  # of the ten cameras, in the order in which they are added
PAPER = {f"T-{n}": IDS[:n] for n in (2, 3, 4, 5, 6, 8, 10)}
LEFT_OUT = {"T-all": IDS} | {f"T-no{i}": tuple(j for j in IDS if j != i) for i in IDS}


def rows_of(
    rng: np.random.Generator, subsets: dict, bad: int | None, shared: bool = True
) -> list[dict]:
    """Rows of ten minutes from ten cameras, whose noise differs by 10 %, the bad one's by two."""
    facility, noise = random_facility(rng, 10), np.exp(rng.normal(0, 0.1, 10))
    noise[IDS.index(bad) if bad else slice(0)] *= 2
    found, names = additions(subsets), list(subsets)
    chosen = [[IDS.index(i) for i in ids] for ids in subsets.values()]
    sums = np.zeros((2, 1, len(found), N_BLOCKS, 6, 6))
    for marker in range(2):
        joint = joint_covariance(facility, marker, noise, chosen)
        own = np.arange(len(joint)) // 3
        joint = joint if shared else np.where(own[:, None] == own, joint, 0.0)
        blocks = wishart_blocks(rng, joint, 48_000, N_BLOCKS)
        for k, addition in enumerate(found):
            at = [3 * names.index(name) for name in (addition.smaller, addition.larger)]
            pick = np.r_[at[0] : at[0] + 3, at[1] : at[1] + 3]
            sums[marker, 0, k] = blocks[:, pick[:, None], pick]
    told = diagnose(Moments((1 / 120,), sums, np.ones(sums.shape[:4])), found, subsets)
    return addition_rows("T40", found, subsets, ("Wand1", "Wand2"), told, LIMITS["rise"])


def named(rows: list[dict]) -> list[set[int]]:
    return [{int(i) for i in row["added"].split(";")} for row in noisy(rows, LIMITS["noisy"])]


@pytest.mark.parametrize(
    ("subsets", "bad", "told"),
    [
        (PAPER, 11, {11, 12}),
        (PAPER, 13, {13}),
        (PAPER, 16, {16}),
        (PAPER, 20, {19, 20}),
        (LEFT_OUT, 11, {11}),
        (LEFT_OUT, 20, {20}),
    ],
)
def test_the_noisy_camera_or_its_set_is_named_alone(subsets: dict, bad: int, told: set) -> None:
    rng = np.random.default_rng([13, bad, len(subsets)])
    right = [named(rows_of(rng, subsets, bad)) == [told] for _ in range(5)]
    assert sum(right) >= 4


def test_sound_cameras_are_not_blamed() -> None:
    rng = np.random.default_rng(14)
    for subsets in (PAPER, LEFT_OUT):
        sound = [rows_of(rng, subsets, None) for _ in range(6)]
        assert not any(named(rows) or raised(rows) for rows in sound)


def test_without_shared_frames_a_rise_is_all_there_is() -> None:
    rng = np.random.default_rng(15)
    rows = [rows_of(rng, PAPER, 15, shared=False) for _ in range(6)]
    assert not any(named(r) for r in rows)
    assert sum(bool(raised(r)) and raised(r)[0]["added"] == "15" for r in rows) >= 4
    words = summary(rows[0], [], LIMITS)["words"]
    assert any("do not share their frames" in line for line in words)
    told = summary(next(r for r in rows if raised(r)), [], LIMITS)
    assert told["apart"] and len(told["short"]) == 1
    assert told["short"][0].startswith("T40: adding camera")


def test_words_name_camera_factor_and_direction() -> None:
    rows = rows_of(np.random.default_rng(16), PAPER, 15)
    assert list(rows[0]) == list(COLUMNS) and len(rows) == 1 + 2 * 6
    told = summary(rows, [], LIMITS)
    (camera,) = told["noisy"]
    assert camera["added"] == "15" and camera["camera_noise"] == pytest.approx(2, rel=0.3)
    factor = f"{camera['camera_noise']:.1f}"
    assert told["short"] == [f"T40: camera 15 is {factor} times as noisy as the others."]
    (rise,) = told["raised"]
    assert (rise["from"], rise["to"]) == ("T-4", "T-5")
    assert np.hypot(np.hypot(rise["direction_x"], rise["direction_y"]), rise["direction_z"]) == (
        pytest.approx(1)
    )
    assert told["words"][0].startswith("T40: camera 15 is")
    assert "from 4 to 5 cameras (15 added)" in told["words"][1]
    assert "the law predicts 0.89" in told["words"][1]
    assert all("at one frame" in line for line in told["words"][:2])
    assert "least squares" not in told["words"][1]  # a bound, where the noise itself is known
    law = [{"camera_type": "T40", "series": "x1"} | dict.fromkeys(LAW_COLUMNS[3:], 0.5)]
    words = summary(rows, law, LIMITS)["words"]
    assert words[:2] == told["words"][:2] and "as n^-b" in words[-1]


def test_words_of_sound_cameras_and_of_the_first() -> None:
    rng = np.random.default_rng(17)
    quiet = summary(rows_of(rng, PAPER, None), [], LIMITS)
    assert quiet["raised"] == quiet["noisy"] == []
    assert quiet["words"] == [
        "T40: no addition of cameras raised the noise by more than 5 % in any direction.",
        "T40: no camera is 1.5 times as noisy as the others.",
    ]
    assert quiet["short"] == ["T40: no added camera raised the noise."] and not quiet["apart"]
    first = summary(rows_of(rng, PAPER, 12), [], LIMITS)["words"]
    assert first[0].startswith("T40: one of the cameras 11, 12 is")


def test_a_rise_by_a_sound_camera_is_laid_to_an_earlier_one() -> None:
    rng = np.random.default_rng(19)
    for _ in range(40):  # until the geometry is such that one raises the noise
        rows = rows_of(rng, PAPER, 11)
        if raised(rows):
            break
    told = summary(rows, [], LIMITS)
    assert {row["cause"] for row in told["raised"]} == {"earlier"}
    assert "one of the cameras 11, 12 is" in told["words"][0]
    assert told["words"][1].startswith("T40: cameras that are not noisy themselves raised")
    assert len(told["words"]) == 2


def test_a_set_is_not_named_for_a_camera_that_is() -> None:
    base = {"tau_s": 0.008, "camera_noise": 2.0, "camera_noise_p": 1e-6}
    rows = [base | {"added": "3;4"}, base | {"added": "4", "camera_noise": 1.9}]
    assert [row["added"] for row in noisy(rows, 1.5)] == ["4"]


def test_a_rise_has_to_be_large_and_sure() -> None:
    assert word(1.2, 1e-6, 0.9, 0.05) == "raises"
    assert word(1.04, 1e-6, 0.9, 0.05) == "falls"
    assert word(1.2, 0.01, 1.1, 0.05) == "same"


def test_law_table_takes_what_is_known() -> None:
    n = {"a": 2, "b": 4, "c": 8}
    sigma = {k: {"x1": v**-0.5, "y1": 1.0} for k, v in n.items()}
    h_0 = {k: {"x1": 1 / v, "y1": float("nan"), "L": v**-2.0} for k, v in n.items()}
    x, y, length = law_rows("T40", n, sigma, h_0)
    assert (x["b"], x["h_0_b"], x["h_0_scatter"]) == pytest.approx((0.5, 0.5, 0), abs=1e-9)
    assert y["b"] == pytest.approx(0) and y["h_0_b"] is None
    assert length["b"] is None and length["h_0_b"] == pytest.approx(1.0)


def levels(subsets: dict, scale: float = 1.0) -> dict:
    """What the figure needs of each recording: noise that falls as 1/n."""
    names = ("x1", "y1", "z1", "x2", "y2", "z2")
    return {
        name: {"n": len(ids), "without": [i for i in IDS if i not in ids]}
        | dict.fromkeys(names, scale * 0.1 / len(ids))
        for name, ids in subsets.items()
    }


def bars(axes) -> list[tuple[float, float, float]]:
    """Value, lower and upper end of every interval drawn in a panel."""
    found = []
    for one in axes.containers:
        line, _, (ends,) = one.lines
        found += [
            (y, low[1], high[1])
            for y, (low, high) in zip(line.get_ydata(), ends.get_segments(), strict=True)
        ]
    return sorted(found)


@pytest.mark.parametrize("subsets", [PAPER, LEFT_OUT])
def test_figure_has_a_panel_for_each_question(tmp_path, subsets: dict) -> None:
    rows = rows_of(np.random.default_rng(18), subsets, 15)
    source = "Source: 7 measured recordings."
    picture = camera_figure(rows, {"T40": levels(subsets)}, LIMITS, "Cameras", source, "More.")
    _, of_rise, of_camera = picture.figure.axes
    titles = [axes.get_title(loc="left")[:3] for axes in picture.figure.axes]
    assert titles == ["(a)", "(b)", "(c)"] and all(t in picture.caption for t in titles)
    assert picture.caption.endswith("More.")
    labels = [axes.get_ylabel() for axes in picture.figure.axes]
    assert labels == [
        "Allan deviation,\none frame (mm)",
        "Noise of subset /\nof the smaller one",
        "Noise of camera /\nmedian of all",
    ]
    ticks = [[t.get_text() for t in axes.get_xticklabels()] for axes in (of_rise, of_camera)]
    assert all(text.startswith("id ") for text in ticks[0])  # +2 would read as two cameras
    assert subsets is LEFT_OUT or ticks[1][0] == "id 11\nid 12"
    noise = ("camera_noise", "camera_noise_lower_95", "camera_noise_upper_95")
    known = {(r["from"], r["to"]): tuple(r[k] for k in noise) for r in rows if r["camera_noise"]}
    assert np.allclose(bars(of_camera), sorted(known.values()))
    up = len({(row["from"], row["to"]) for row in raised(rows)})
    shaded = [patch for patch in of_rise.patches if patch.get_facecolor()[3] < 1]
    assert len(shaded) == up + 1  # and one for the legend
    check_saved(picture, tmp_path / "cameras")


def test_camera_types_share_their_scales() -> None:
    """Five types of very different noise, in two rows of columns; long names."""
    rng, kinds = np.random.default_rng(20), [f"{k}_{'camera-' * 9}" for k in range(5)]
    rows = [row | {"camera_type": k} for k in kinds for row in rows_of(rng, PAPER, 15)]
    sigma = {kind: levels(PAPER, 10.0**k) for k, kind in enumerate(kinds)}
    picture = camera_figure(rows, sigma, LIMITS, ODD_TEXT, ODD_TEXT)
    check(picture)
    shown = [axes for axes in picture.figure.axes if axes.axison]
    assert len(shown) == 3 * len(kinds)
    of_name = [axes for axes in shown if axes.get_xlabel() == "Number of cameras"]
    assert len({axes.get_ylim() for axes in of_name}) == 1 < len(of_name)
    for axes, k in zip(of_name, range(5), strict=True):
        low, high = axes.get_ylim()
        assert low < 10.0**k * 0.01 and 10.0**k * 0.05 < high


def test_figure_of_nothing(tmp_path) -> None:
    sigma = {"T40": {"a": {"n": 2, "without": [3], "x1": 1.0}, "b": {"n": 3, "without": []}}}
    picture = camera_figure([], sigma, LIMITS, "Cameras", "Source: nothing.")
    assert every_text(picture).count("no addition of cameras") == 1
    check_saved(picture, tmp_path / "nothing")
