"""Pairing of Gauss-Markov terms: closed cases."""

import itertools
import math

import numpy as np
import pytest

from mocap_metrology.papers.coefficient_tables import LIMIT, pair, partners


@pytest.mark.parametrize(
    ("published", "fitted", "expected"),
    [
        ([0.1, 1, 10], [0.1, 1, 10], {1: 1, 2: 2, 3: 3}),
        ([10, 0.1, 1], [0.1, 1, 10], {1: 3, 2: 1, 3: 2}),
        # The order alone would pair 0.01 with 0.12; distance does not
        ([0.01, 0.1, 1], [0.12, 0.9], {2: 1, 3: 2}),
        ([0.1], [0.1 * LIMIT], {1: 1}),
        ([0.1], [0.101 * LIMIT], {}),
        # One good pair is worth more than two that differ by a factor of 9
        ([0.01, 0.1], [0.09, 0.9], {2: 1}),
        # Nearest first would take 1 with 1.5 and leave 3 alone with 0.4
        ([1, 3], [1.5, 0.4], {1: 2, 2: 1}),
        ([], [1.0], {}),
        ([1.0], [], {}),
        ([100], [90, 2000, 130], {1: 1}),
    ],
)
def test_closed_cases(published, fitted, expected) -> None:
    found = pair(dict(enumerate(published, start=1)), dict(enumerate(fitted, start=1)))
    assert found == expected


def test_no_assignment_is_better_than_the_one_chosen() -> None:
    rng = np.random.default_rng(5)
    far = math.log(LIMIT)

    def cost(ours, theirs, chosen) -> float:
        paired = sum(abs(math.log(ours[i] / theirs[j])) for i, j in chosen.items())
        return paired + far * (min(len(ours), len(theirs)) - len(chosen))

    for _ in range(50):
        ours, theirs = (
            dict(enumerate(10 ** rng.uniform(-2, 3.3, rng.integers(1, 5)))) for _ in range(2)
        )
        best = math.inf
        for k in range(min(len(ours), len(theirs)) + 1):
            for some in itertools.combinations(ours, k):
                for others in itertools.permutations(theirs, k):
                    best = min(best, cost(ours, theirs, dict(zip(some, others, strict=True))))
        assert cost(ours, theirs, pair(ours, theirs)) == pytest.approx(best, abs=1e-9)


def test_partners_go_by_name_or_by_term() -> None:
    published = {"h_0": 1.0, "q_c1": 1, "T_c1": 9.0, "q_c2": 1, "T_c2": 0.1, "A_s": 1, "f_0": 14.4}
    fitted = {"h_0": 2.0, "q_c1": 1, "T_c1": 0.1, "q_c2": 1, "T_c2": math.nan, "A_s": math.nan}
    assert partners(published, fitted) == {
        "h_0": "h_0",
        "A_s": "A_s",
        "q_c2": "q_c1",
        "T_c2": "T_c1",
    }
