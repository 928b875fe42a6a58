"""Two calibrations compared: closed forms, what both share, and a Monte Carlo of moved stations."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2, f

from benchmarks.sentences import objects
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import write_json
from mocap_metrology.lighthouse.assess.comparison import (
    SOUND_M2,
    _significance,
    compare_with_earlier,
    length_interval,
)
from mocap_metrology.lighthouse.assess.fit_checks import Case
from mocap_metrology.lighthouse.assess.pose_file import read_pose_json
from mocap_metrology.lighthouse.assess.summary import Summary, with_objects
from mocap_metrology.lighthouse.assess.validation import Verdict
from mocap_metrology.lighthouse.records import SharedErrors, Station
from mocap_metrology.present.text.calibration import pose_document
from tests.lighthouse.assess.test_pose_file import R, T, content, estimate


def test_significance_is_that_of_both_covariances():
    turn = Rotation.from_rotvec(np.radians([0, 0.02, 0])).as_matrix()
    new = content([estimate(t=np.add(T, [0.02, 0, 0]), turn=turn @ R)])
    found = compare_with_earlier(new, content())
    expected = 20**2 / 8 + 0.02**2 / 2e-4
    assert found.chi2 == pytest.approx(expected, rel=1e-6)
    # Hotelling's T^2 of 2 x 19 degrees of freedom, see test_false_alarms
    assert found.p_value == pytest.approx(f.sf(expected * 33 / (38 * 6), 6, 33), rel=1e-4)
    assert found.moved and found.other is None and found.note == ""
    np.testing.assert_allclose(found.difference_mm, [20, 0, 0], atol=1e-9)
    np.testing.assert_allclose(found.difference_deg, [0, 0.02, 0], atol=1e-9)


def test_other_stations_are_refused():
    for a, b, match in ((12, 11, "12 as master and 11 as slave"), (11, 13, "station 13, .* is 12")):
        old = content(stations=[Station("master", a), Station("slave", b)])
        with pytest.raises(Refusal, match=match):
            compare_with_earlier(content(), old)
    unknown = content(stations=[Station("master"), Station("slave", 12)])
    assert "Station ids not compared" in compare_with_earlier(content(), unknown).note
    none = content([], chosen=None)
    for new, old, which in ((content(), none, "earlier"), (none, content(), "new")):
        with pytest.raises(Refusal, match=f"the {which} calibration has no pose"):
            compare_with_earlier(new, old)


def test_false_alarms():
    """Two poses of one place, covariances estimated from 20 blocks each: 5 % of 2000 draws have a
    probability below 5 %, within three standard errors (1.5 %)."""
    rng, alarms = np.random.default_rng(3), 0
    for _ in range(2000):
        means, covariances = [], []
        for _ in range(2):
            blocks = rng.normal(0, np.sqrt(20), (20, 6))
            means.append(blocks.mean(axis=0))
            covariances.append(np.cov(blocks.T) / 20)
        total = covariances[0] + covariances[1]
        alarms += _significance(means[0] - means[1], total, "sum")[1] < 0.05
    assert alarms / 2000 == pytest.approx(0.05, abs=0.015)


# Two groups of errors, of which the second recording feels the first as the other does.
EFFECT = np.array([[3.0, 1, 0, 0.02, 0, 0], [0, 0, 2, 0, 0, 0]])
NOISE = np.diag([0.04, 0.04, 0.04, 1e-5, 1e-5, 1e-5])


def joint(t=T, effect=EFFECT, board="a", sd=(1e-3, 2e-4)):
    """An estimate with a board and optics in its covariance."""
    shared = SharedErrors(np.array(sd), effect, np.array([False, True]), board)
    whole = NOISE + effect.T @ effect
    return replace(
        estimate(t=t, covariance=whole, covariance_noise=NOISE, shared=shared), estimator="batch"
    )


def test_errors_that_both_share_cancel(tmp_path):
    """3 mm along an error that makes 3 mm in each: invisible beside both covariances, clear
    beside their noise, and so after being written, saved by an editor of Windows, and read."""
    write_json(tmp_path / "pose.json", content([joint()]))
    (tmp_path / "pose.json").write_bytes(b"\xef\xbb\xbf" + (tmp_path / "pose.json").read_bytes())
    old = read_pose_json(tmp_path / "pose.json")
    new = content([joint(np.add(T, [0.003, 0.001, 0]))])
    found = compare_with_earlier(new, old)
    assert found.basis == "difference" and found.moved and not found.valid
    assert found.chi2 == pytest.approx(10 / 0.08, rel=1e-6)
    assert found.p_value == pytest.approx(chi2.sf(10 / 0.08, 6), rel=1e-3)
    assert found.as_dict()["shift_mm"] == pytest.approx(math.sqrt(10))
    assert found.lower_95[0] < math.sqrt(10) < found.upper_95[0] < math.sqrt(10) + 1
    for m2, noise in ((SOUND_M2 / 2, 0.08), (4 * SOUND_M2, 0.2)):
        new["poses"][0]["halves"] = {"m2": m2}  # parts that differ count their noise more
        assert compare_with_earlier(new, old).chi2 == pytest.approx(10 / noise, rel=1e-6)
    for entry in (*old["poses"], *new["poses"]):
        entry.pop("shared_errors")
    blind = compare_with_earlier(new, old)
    assert blind.basis == "sum" and not blind.moved and blind.valid


def test_the_same_variant_of_the_rotors_is_compared():
    """Recordings that choose different variants, 4 mm apart in both, have the same pose."""

    def variants(chosen):
        return [
            {"variant": name, "chosen": name == chosen, "translation_mm": [x, 0, 0],
             "standing": "chosen" if name == chosen else "open", "rotation_matrix": np.eye(3)}
            for name, x in (("crazyflie", 0.0), ("libsurvive", 4.0))
        ]  # fmt: skip

    old = content([replace(joint(), optics="factory")]) | {"variants": variants("crazyflie")}
    new = content([replace(joint(np.add(T, [0.004, 0, 0])), optics="factory")])
    assert compare_with_earlier(new, old).moved
    found = compare_with_earlier(new | {"variants": variants("libsurvive")}, old)
    assert found.shift[0] == pytest.approx(0, abs=1e-9) and found.valid


def test_poses_of_other_origins_are_refused():
    new = content([replace(estimate(), frame="housing")])
    with pytest.raises(Refusal, match="is of frame optical, the new one of housing"):
        compare_with_earlier(new, content())


SOUND = {"sd": [1e-3, 2e-3], "effect": [[0.1] * 6, [0.2] * 6]}
LOPSIDED = np.eye(6) + 1e-3 * np.eye(6, k=1)
ODD = [
    *({"sd": [1e-3, sd]} for sd in (0.0, -1e-9, math.nan, math.inf)),
    *({"effect": effect} for effect in ([[0.1] * 6], [[0.1] * 6, [math.nan] * 6])),
    *({"sd": [[1e-3, 2e-3]]}, {"sd": 1e-3, "effect": [0.1] * 6}),
]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("shared_errors", {}),
        *(
            ("shared_errors", {"digest": "a", "stations": SOUND, "board": SOUND, part: SOUND | odd})
            for part in ("stations", "board")
            for odd in ODD
        ),
        *(("covariance_noise", C.tolist()) for C in (LOPSIDED, np.eye(5), np.nan * np.eye(6))),
    ],
)
def test_damaged_errors_are_refused(tmp_path, key, value):
    write_json(tmp_path / "pose.json", content([joint()]))
    document = json.loads((tmp_path / "pose.json").read_text())
    document["poses"][0][key] = value
    (tmp_path / "pose.json").write_text(json.dumps(document))
    with pytest.raises(Refusal, match="is no pose"):
        read_pose_json(tmp_path / "pose.json")


@pytest.mark.parametrize("true", [0.0, 0.7, 8.0])
def test_intervals_hold_the_true_length(true):
    """Of 300 draws with unequal variances at least 95 % less three standard errors."""
    rng = np.random.default_rng(int(10 * true))
    covariance = np.diag([1.0, 0.3, 0.05])
    held = 0
    for _ in range(300):
        way = rng.normal(size=3)
        measured = true * way / np.linalg.norm(way) + rng.normal(size=3) * np.sqrt([1, 0.3, 0.05])
        low, high = length_interval(measured, covariance)
        assert low <= np.linalg.norm(measured) <= high
        held += low <= true <= high
    assert held / 300 > 0.95 - 3 * math.sqrt(0.95 * 0.05 / 300)
    far = length_interval(np.array([100.0, 0, 0]), covariance)
    assert far == pytest.approx((98.04, 101.96), abs=0.05)


def of(word: str, *poses) -> Summary:
    document = content(list(poses) or [joint()], chosen=0)
    document["verdict"]["word"], document["checks"] = word, []
    return Summary(document, Verdict(word))


def off(chi: float):
    """An estimate that differs from `joint()`, of another board, by this squared distance."""
    return joint(np.add(T, [0, 0, 1e-3 * np.sqrt(chi * (0.08 + 2 * 2**2))]))


LIMIT = chi2.isf(0.01, 6)


@pytest.mark.parametrize(
    ("alone", "together"),
    [("good", "usable"), ("usable", "doubtful"), ("doubtful", "doubtful"), ("failed", "failed")],
)
def test_beyond_the_joint_99_percent_a_word_is_one_worse(alone: str, together: str) -> None:
    near, far = (of("good", off(times * LIMIT)).document for times in (0.99, 1.01))
    same = with_objects(of(alone), {"other": near})
    assert same.verdict.word == alone
    assert [c.case for c in same.verdict.checks] == [Case.OBJECTS]
    lower = with_objects(of(alone), {"other": far})
    assert lower.verdict.word == lower.document["verdict"]["word"] == together
    (check,) = lower.verdict.checks
    assert check.value == pytest.approx(chi2.sf(1.01 * LIMIT, 6), rel=1e-3)
    assert check.numbers["mm"] == pytest.approx(np.sqrt(1.01 * LIMIT * 8.08))
    said = pose_document(lower)
    assert (
        "from other, another object of the same recording, differs by 12 mm"
        in said["checks"][0]["sentence"]
    )
    if alone != "failed":
        assert said["checks"][0]["sentence"] == said["verdict"]["reason"]


def test_what_states_no_pose_is_not_compared() -> None:
    own = of("usable")
    blind = of("good", estimate(t=np.add(T, [1, 0, 0]), covariance=None)).document
    failed = of("failed", off(10 * LIMIT)).document
    assert with_objects(own, {"none": content([], chosen=None), "a": blind, "b": failed}) is own


@pytest.mark.parametrize("n", [1, pytest.param(40, marks=pytest.mark.study)])
def test_pairs_of_twins(n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two sound objects agree within chance; the words of both are lower where the file of one is
    stretched by 3 % along an axis."""
    monkeypatch.setattr(objects, "SECONDS", 2.0 if n == 1 else 6.0)
    sound = [objects.pair(seed) for seed in range(n)]
    p = [float(one.verdict.checks[-1].value) for one, _ in sound]
    assert objects.kstest(p, "uniform").pvalue > 0.01
    for own in objects.pair(0, objects.STRETCH):
        assert own.verdict.word in ("usable", "doubtful")
        assert own.verdict.checks[-1].case is Case.OBJECTS_APART
