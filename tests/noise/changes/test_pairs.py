"""Two recordings before they are compared: markers by their labels, and what makes their noise
differ beside the system."""

from typing import Any

import numpy as np
import pytest

from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.changes.rows import Side, compare_rows, conditions
from mocap_metrology.noise.series import ALLAN_MASKED, STRETCHES, allan_columns, joined

SETTINGS = {"margin": 0.05, "alpha": 0.01, "confidence": 0.95}


def white(rng: np.random.Generator, sd_mm: float, n: int = 6000) -> np.ndarray:
    return sd_mm * rng.standard_normal((3, n))


def side(
    markers: dict[str, np.ndarray],
    pairs: list[tuple[str, str]] | None = None,
    rate_hz: float = 100.0,
    findings: list[dict[str, Any]] | None = None,
) -> Side:
    """A recording of markers (3, n), the first coordinate of which are apart by 100 mm."""
    labels = list(markers)
    numbers = {label: k for k, label in enumerate(labels, start=1)}
    series = {
        f"{a}{numbers[m]}": v for m, xyz in markers.items() for a, v in zip("xyz", xyz, strict=True)
    }
    of = [(numbers[a], numbers[b]) for a, b in pairs or [(labels[0], labels[1])]]
    for k, (a, b) in enumerate(of):
        apart = np.array([100.0, 0, 0])[:, None] + markers[labels[b - 1]] - markers[labels[a - 1]]
        series[f"L_{a}_{b}" if k else "L"] = np.sqrt((apart**2).sum(axis=0))
    m = averaging_factors(next(iter(series.values())).size, 40, 1, 1 / 3)
    parts = [
        allan_columns(n, allan_curve(v, rate_hz, m).as_scattered(v), "oadev")
        for n, v in series.items()
    ]
    origin = {"labels": labels, "pairs": of, "frame_rate_hz": rate_hz}
    return Side("r", joined(parts, ALLAN_MASKED), origin, findings or ())


def compared(new: Side, old: Side) -> tuple[list[dict], list[dict]]:
    old = old.named_as(new)
    rows = compare_rows("new", "old", new.columns, old.columns, **SETTINGS)
    return rows, conditions(new, old, rows)


def test_markers_are_compared_by_label_in_whatever_order_a_sheet_names_them() -> None:
    """B is twice as noisy as A in both recordings; C, of the second alone, is quiet. Distances of
    the same ends belong together, also where their pairs are others."""
    rng = np.random.default_rng(4)
    first, second = (
        {label: white(rng, sd) for label, sd in (("A", 0.02), ("B", 0.04), ("C", 0.001))}
        for _ in range(2)
    )
    new = side({k: first[k] for k in "AB"})
    old = side({k: second[k] for k in "BCA"}, [("B", "C"), ("A", "B")])
    rows, known = compared(new, old)
    assert {row["series"] for row in rows} == {"x1", "y1", "z1", "x2", "y2", "z2", "L"}
    assert {row["word"] for row in rows} == {"same"}
    assert [(one["code"], one["series"]) for one in known] == [("gone", ["C"])]
    frames = [row["ratio"] for row in rows if row["tau_s"] == 0.01]
    assert frames == pytest.approx([1] * 7, abs=0.07)
    rows, known = compared(old, new)
    assert [one["series"] for one in known] == [["x2", "y2", "z2", "L"]]
    renamed = side(dict(zip("PQ", (second["A"], second["B"]), strict=True)))
    rows, known = compared(renamed, new)
    assert {row["word"] for row in rows} == {"same"}
    assert [one["code"] for one in known] == ["by_number"]


def test_one_recording_that_was_exported_twice_is_no_comparison() -> None:
    """To 0.001 mm the second time. Of 40 pairs of one system none is taken for one recording."""
    rng = np.random.default_rng(5)
    for _ in range(40):
        one, other = ({k: white(rng, 0.02, 1000) for k in "AB"} for _ in range(2))
        assert compared(side(one), side(other))[1] == []
    rounded = {k: np.round(v, 3) for k, v in one.items()}
    for again in (one, rounded):
        assert [row["code"] for row in compared(side(again), side(one))[1]] == ["same_data"]


def test_rates_a_constant_marker_a_filter_and_movement_are_reported() -> None:
    """Of equal white noise of a frame at 400 and 100 Hz the ratio is a half."""
    rng = np.random.default_rng(6)
    fast = side({k: white(rng, 0.02, 24_000) for k in "AB"}, rate_hz=400.0)
    slow = side({k: white(rng, 0.02) for k in "AB"})
    rows, (known,) = compared(fast, slow)
    assert known == {"code": "rates", "new_hz": 400.0, "old_hz": 100.0, "white": 0.5}
    at = [row["ratio"] for row in rows if row["tau_s"] == 0.1]
    assert at == pytest.approx([known["white"]] * 7, rel=0.2)
    held = side({"A": white(rng, 0.02), "B": np.zeros((3, 6000))})
    rows, (known,) = compared(held, slow)
    assert (known["code"], known["series"]) == ("left_out", ["x2", "y2", "z2"])
    three = side({k: white(rng, 0.02) for k in "CAB"})
    gone, _ = compared(slow, three)[1]
    assert gone == {"code": "gone", "recording": "r", "series": ["C"]}
    cutoffs = [{"code": "low_pass", "series": f"x{k}", "value": k + 5.0} for k in (1, 2)]
    moves = [{"code": "moves", "series": "x1", "value": 3.0}, {"code": "gaps", "value": 1.0}]
    markers = [{k: white(rng, 0.02) for k in "AB"} for _ in range(2)]
    rows, known = compared(
        *(side(m, findings=f) for m, f in zip(markers, (cutoffs, moves), strict=True))
    )
    assert [(row["code"], row["value"]) for row in known] == [("low_pass", 6.0), ("moves", 3.0)]
    assert not compared(*(side(m, findings=cutoffs) for m in markers))[1]


def test_a_wandering_level_widens_the_interval_of_its_mean() -> None:
    """200 pairs of a minute whose level wanders within 5 s: 95 % intervals of the ratio hold in 93
    % at least (seed 3: 96 %, and 90 % with the first correlation alone for that of all parts)."""
    from scipy.signal import lfilter

    rng, held, n = np.random.default_rng(3), 0, 6000
    step, m = np.exp(-1 / 500), averaging_factors(n, 10, 1, 0.1)
    for _ in range(200):
        curves = []
        for _ in range(2):
            drive = rng.standard_normal(2 * n) * 0.3 * np.sqrt(1 - step**2)
            level = np.exp(lfilter([1.0], [1.0, -step], drive)[n:])
            values = level * rng.standard_normal(n)
            columns = allan_columns(
                "x1", allan_curve(values, 100.0, m).as_scattered(values), "oadev"
            )
            curves.append(columns)
        assert STRETCHES[0] in curves[0]
        row = compare_rows("new", "old", *curves, **SETTINGS)[0]
        held += row["lower"] < 1 < row["upper"]
    assert held / 200 >= 0.93
