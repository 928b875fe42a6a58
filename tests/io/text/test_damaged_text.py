"""Text files as transfers, programs and accidents leave them: refused in one line, or harmless."""

import pytest
from text_files import LABELS, PLAIN, make, read, refusal, row, spoilt


@pytest.mark.parametrize(
    ("name", "label", "line"),
    [("a.trc", "\tA\t", 4), ("m.csv", '"A"', 4), ("a.tsv", "\tA\t", 12), ("n.csv", ",A,", 3)],
)
def test_a_carriage_return_inside_the_header(tmp_path, name, label, line):
    """A spreadsheet would read two lines, and another program a blank."""
    path = spoilt(tmp_path, name, label, label.replace("A", "A\r"))
    assert refusal(path) == f"{name}: line {line} has a carriage return inside"


LONG = "1" * 200_000
SPACES = " " * 100_000


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("a.trc", "\t20\t2\tmm", f"\t{LONG}x\t2\tmm"),
        ("a.trc", "\t20\t2\tmm", "\t20\t1e12\tmm"),
        ("a.trc", "\t20\t2\tmm", "\t1e999\t2\tmm"),
        ("a.tsv", "NO_OF_FRAMES\t20", f"NO_OF_FRAMES\t{LONG}x"),
        ("a.tsv", "NO_OF_FRAMES\t20", "NO_OF_FRAMES\t1e999"),
        ("n.csv", "Trajectories\r\n", f"TRAJECTORIES\n1{SPACES}x\n"),
        ("n.csv", "\n2,0,", f"\n2,0,1{SPACES}2"),
        ("m.csv", "\n2,", f"\n2{SPACES}x,"),
    ],
)
def test_long_cells_cost_no_time(tmp_path, cost, name, old, new):
    """A pattern that can match a run of digits or blanks in several ways takes minutes."""
    path, plain = spoilt(tmp_path, name, old, new), make(tmp_path, f"plain_{name}", PLAIN[name])

    def refuse() -> None:
        assert len(refusal(path)) < 2100

    def read_some() -> None:
        for _ in range(10):
            read(plain, LABELS)

    assert cost(refuse, read_some) < 30


def test_an_unreadable_pose_is_no_gap(tmp_path):
    pose = "1 0 0 0.1 0 1 0 0.2 0 0 1 0.3"
    nan = " ".join(["nan"] * 12)
    good = make(tmp_path, "good.txt", "\n".join(["# Freq: 10", pose, nan, pose, ""]))
    assert read(good, ["tracker"]).n_invalid[0]["empty"] == 1
    for line, message in (
        ("lost", "line 3 has 1 cells, expected 12"),
        ("1 0 0", "line 3 has 3 cells, expected 12"),
        (pose.replace("1 0 0 0.1", "x 0 0 0.1"), "line 3, column 1: 'x' is not a number"),
        (f"{pose} 7", "line 3 has 13 cells, expected 12"),
    ):
        path = make(tmp_path, "a.txt", "\n".join(["# Freq: 10", pose, line, pose, ""]))
        assert message in refusal(path, ["tracker"])


@pytest.mark.parametrize("name", PLAIN)
def test_a_row_without_its_time_is_no_gap(tmp_path, name):
    if name == "n.csv":
        pytest.skip("Nexus writes no times")
    own, mark = row(name, 9), "," if name == "m.csv" else "\t"
    path = spoilt(tmp_path, name, f"{own.strip()}", own.split(mark)[0])
    assert "has no time, as other lines have" in refusal(path)
