"""Tables, sentences and figure of camera subsets, on a system whose noisy camera is known.

`tests/noise/cameras` and `benchmarks/failing_camera.py` count how often it is found.
"""

import numpy as np
import pytest
from figure_data import check_saved
from said import numbers_in

from benchmarks.failing_camera import wishart_blocks
from mocap_metrology.noise.cameras import findings
from mocap_metrology.noise.cameras.diagnosis import N_BLOCKS, Moments, additions, diagnose
from mocap_metrology.noise.twins.take import joint_covariance, random_facility
from mocap_metrology.present.cameras import camera_figure, summary
from mocap_metrology.present.plot.figure import Texts

LIMITS = {"rise": 0.05, "noisy": 1.5}
IDS = tuple(range(11, 21))  # of the ten cameras, in the order in which they are added
PAPER = {f"T-{n}": IDS[:n] for n in (2, 3, 4, 5, 6, 8, 10)}
LEFT_OUT = {"T-all": IDS} | {f"T-no{i}": tuple(j for j in IDS if j != i) for i in IDS}


def rows_of(rng, subsets: dict, bad: int | None, true: dict | None = None) -> list[dict]:
    """Rows of ten minutes from ten cameras, whose noise differs by 10 %, the bad one's by two.
    true: cameras of which the recordings are, where a sheet is wrong."""
    facility, noise = random_facility(rng, 10), np.exp(rng.normal(0, 0.1, 10))
    if bad:
        noise[IDS.index(bad)] *= 2
    found, names = additions(subsets), list(subsets)
    chosen = [[IDS.index(i) for i in ids] for ids in (true or subsets).values()]
    sums = np.zeros((2, 1, len(found), N_BLOCKS, 6, 6))
    for marker in range(2):
        joint = joint_covariance(facility, marker, noise, chosen)
        blocks = wishart_blocks(rng, joint, 48_000, N_BLOCKS)
        for k, addition in enumerate(found):
            at = [3 * names.index(name) for name in (addition.smaller, addition.larger)]
            pick = np.r_[at[0] : at[0] + 3, at[1] : at[1] + 3]
            sums[marker, 0, k] = blocks[:, pick[:, None], pick]
    diagnosis = diagnose(Moments((1 / 120,), sums, np.ones(sums.shape[:4])), found, subsets)
    how = found, subsets, ("Wand1", "Wand2"), diagnosis, LIMITS["rise"]
    rows = findings.addition_rows("T40", *how)
    assert all(list(row) == list(findings.COLUMNS) for row in rows)
    return rows


def test_recordings_that_are_exchanged_blame_no_camera() -> None:
    """The files of four and five cameras are exchanged in 20 halls: reported in 80 % at least, and
    then no camera is called noisy. In the same halls without the exchange nothing is reported."""
    wrong = PAPER | {"T-4": PAPER["T-5"], "T-5": PAPER["T-4"]}
    reported = 0
    for seed in range(20):
        assert not findings.exchanged(rows_of(np.random.default_rng(seed), PAPER, None))
        rows = rows_of(np.random.default_rng(seed), PAPER, None, wrong)
        if pairs := [(row["from"], row["to"]) for row in findings.exchanged(rows)]:
            assert pairs == [("T-4", "T-5")] and not findings.noisy(rows, LIMITS["noisy"])
            reported += 1
    assert reported >= 16


NOISY = {"camera_type": "T", "added": "15", "tau_s": 0.01, "camera_noise": 2.04, "marker": "W"}
NOISY |= {"camera_noise_lower_95": 1.9, "camera_noise_upper_95": 2.2, "camera_noise_p": 1e-6}
NOISY |= {"from": "T-4", "to": "T-5", "n_from": 4, "n_to": 5, "word": "same", "same_frames": "yes"}
RISE = NOISY | {"word": "raises", "largest_factor": 1.3, "largest_lower_95": 1.2}
RISE |= {"largest_upper_95": 1.4, "direction_x": 0.1, "direction_y": -0.9, "direction_z": 0.4}
RISE |= {"mean_factor": 1.1, "law_factor": 0.894, "least_camera_noise": 1.7}
SOUND = {"camera_noise": 1.0, "added": "16;17", "to": "T-7"}
NAMED, ALONE = "15, 2.04, 95 %, 1.90, 2.20", "15, 2.0"
RAISED = "4, 5, 15, 1.30, 95 %, 1.20, 1.40, 0.001, {}0.10, -0.90, 0.40, 1.10, 0.89"
APART = [RISE | {"tau_s": 0.1}, NOISY, RISE | {"to": "T-9", "largest_factor": 1.2}]
CASES = {  # rows; numbers in the sentences, and in the short one
    "noisy and raised": ([RISE], [NAMED, RAISED.format("")], ALONE),
    "noisy": (
        [NOISY | {"added": "11;12"}], ["11, 12, 2.04, 95 %, 1.90, 2.20", "5 %"], "11, 12, 2.0"
    ),
    "sound": ([NOISY | SOUND], ["5 %", "1.5"], ""),
    "earlier": (
        [NOISY, RISE | SOUND | {"tau_s": 0.1}], [NAMED, "4, 5, 16, 17, 1.30, 4"], ALONE
    ),
    "earlier, unnamed": ([RISE | SOUND], ["4, 5, 16, 17, 1.30, 4"], "16, 17, 1.3, 4"),
    "not judged": (
        [NOISY | SOUND, NOISY | SOUND | {"from": "", "n_to": 4, "added": "11;12;13;14"}],
        ["5 %", "1.5, 11, 12, 13, 14"], ""
    ),
    "exchanged": (
        [NOISY | {"word": findings.NOTHING, "camera_noise": None}], ["4, 5, 15, 4, 5"],
        "4, 5, 15, 4, 5"
    ),
    "apart": (
        [row | {"same_frames": "no", "camera_noise": None} for row in APART],
        [f"{RAISED.format('0.1 s, ')}, 1.7, 4, 5, 15, 1.20", ""],
        "15, 1.3, 0.1 s",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_numbers_of_sentences(case: str) -> None:
    rows, words, short = CASES[case]
    told = summary(rows, [], LIMITS)
    assert list(map(numbers_in, told["short"])) == [short] and told["apart"] == (case == "apart")
    assert list(map(numbers_in, told["words"])) == words
    assert len(told["raised"]) == sum(row["word"] == "raises" for row in rows)
    assert {r["cause"] for r in told["raised"]} <= {"earlier" if "earl" in case else "added"}


def test_exponents_of_exact_laws_and_their_sentence() -> None:
    n = {"a": 2, "b": 4, "c": 8}
    sigma = {k: {"x1": v**-0.5, "y1": 1.0} for k, v in n.items()}
    h_0 = {k: {"x1": 1 / v, "y1": float("nan"), "L": v**-2.0} for k, v in n.items()}
    rows = findings.law_rows("T", n, sigma, h_0)
    x, y, length = rows
    assert all(list(row) == list(findings.LAW_COLUMNS) for row in rows)
    assert (x["b"], x["h_0_b"], x["h_0_scatter"]) == pytest.approx((0.5, 0.5, 0), abs=1e-9)
    assert y["b"] == pytest.approx(0) and y["h_0_b"] is None
    assert length["b"] is None and length["h_0_b"] == pytest.approx(1.0)
    y |= {"b": -0.001, "b_std_error": 0.1, "b_p": 0.049}
    (said,) = summary([], [x | {"b": 0.5, "b_std_error": 0.02, "b_p": 0.05}, y], LIMITS)["words"]
    assert numbers_in(said).endswith("x1, 0.50, 0.02, y1, -0.00, 0.10, 5 %, y1, 0.00, 0.00")


def levels(subsets: dict, scale: float = 1.0) -> dict:
    """What the figure needs of each recording: noise that falls as 1/n."""
    return {
        name: {"n": len(ids), "without": [i for i in IDS if i not in ids]}
        | dict.fromkeys(("x1", "y1", "z1", "x2", "y2", "z2"), scale * 0.1 / len(ids))
        for name, ids in subsets.items()
    }


@pytest.mark.parametrize("subsets", [PAPER, LEFT_OUT])
def test_figure_has_a_panel_for_each_question(tmp_path, subsets: dict) -> None:
    rows = rows_of(np.random.default_rng(18), subsets, 15)
    texts = Texts("Cameras", "Source: 7.", "More.")
    picture = camera_figure(rows, {"T40": levels(subsets)}, LIMITS, texts)
    _, of_rise, of_camera = picture.figure.axes
    ticks = [text.get_text() for text in of_camera.get_xticklabels()]
    assert ticks == (list(map(str, IDS)) if subsets is LEFT_OUT else
                     ["11\n12", "13", "14", "15", "16", "17\n18", "19\n20"])  # fmt: skip
    line, _, (intervals,) = of_camera.containers[0].lines
    ends = intervals.get_segments()
    drawn = [(y, a[1], b[1]) for y, (a, b) in zip(line.get_ydata(), ends, strict=True)]
    noise = ("camera_noise", "camera_noise_lower_95", "camera_noise_upper_95")
    known = {(r["from"], r["to"]): tuple(r[k] for k in noise) for r in rows if r["camera_noise"]}
    assert np.allclose(sorted(drawn), sorted(known.values()))
    shaded = [p.get_x() for p in of_rise.patches if p.get_width() == 1]
    labels = [text.get_text() for text in of_rise.get_xticklabels()]
    assert [labels[round(x + 0.5)] for x in shaded] == ["15"]
    check_saved(picture, tmp_path / "cameras")


def test_noisy_cameras_count_by_size_certainty_and_averaging_time() -> None:
    base = {"tau_s": 0.01, "camera_noise_p": 9e-4}
    cases = [("3;4", 2.0), ("4", 1.9), ("5", 1.5), ("6", None), ("7", 3.0), ("9", 1.6)]
    rows = [base | {"added": added, "camera_noise": noise} for added, noise in cases]
    rows[4]["camera_noise_p"] = 1e-3
    rows += [rows[0] | {"added": "8", "camera_noise_p": float("nan")}]  # no error is known
    rows += [rows[1] | {"tau_s": 0.1, "camera_noise": 2.2}]  # not clearly greater
    rows += [rows[5] | {"tau_s": tau, "camera_noise": n} for tau, n in ((1.0, 2.1), (1.02, 9.0))]
    loud = findings.noisy(rows, 1.5)
    assert [(row["added"], row["camera_noise"]) for row in loud] == [("9", 2.1), ("4", 1.9)]
