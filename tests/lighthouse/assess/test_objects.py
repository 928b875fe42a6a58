"""Objects of one recording: closed forms of what lowers a word, and pairs of twins."""

import numpy as np
import pytest
from scipy.stats import chi2

from benchmarks.sentences import objects
from mocap_metrology.lighthouse.assess.fit_checks import Case
from mocap_metrology.lighthouse.assess.objects import with_objects
from mocap_metrology.lighthouse.assess.summary import Summary
from mocap_metrology.lighthouse.assess.validation import Verdict
from mocap_metrology.present.text.calibration import pose_document
from tests.lighthouse.assess.test_earlier_pose import joint
from tests.lighthouse.assess.test_pose_file import T, content, estimate


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
