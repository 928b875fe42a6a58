"""A facility from its sheet to table, document and words."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mocap_metrology.accuracy.monitor_row import Row
from mocap_metrology.accuracy.monitor_take import Take, judge
from mocap_metrology.common.faults import Faults
from mocap_metrology.common.sheets import Line
from mocap_metrology.present.monitors import _drawn
from mocap_metrology.recording.monitor import Noises, monitor, steps_of
from mocap_metrology.recording.monitor_sheet import monitors
from mocap_metrology.settings import Settings


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Charts take most of the time of a monitor."""
    module = "mocap_metrology.recording.monitor"
    monkeypatch.setattr(f"{module}.monitors.chart", lambda rows, texts: texts)
    monkeypatch.setattr(f"{module}.save_png", lambda texts, path: path.write_text(texts.title))


DATES = [f"2026-03-{k:02d}" for k in range(1, 31)]


def takes(jump_mm: float = 0, at: int = 99, trend_mm: float = 0) -> dict[str, dict[str, Any]]:
    """monitor_take.json of takes t1, t2, ... of a sound facility, with a jump of x, a length that
    changes from the eleventh on."""
    rng, found = np.random.default_rng(3), {}
    for k in range(1, len(DATES) + 1):
        place = np.array([1000.0, 200, 900]) + rng.normal(0, 0.08, 3)
        place[0] += jump_mm * (k >= at)
        length = 500 + rng.normal(0, 0.03) + trend_mm * max(k - 10, 0)
        take = {
            "jitter_mm": 0.02 * np.exp(rng.normal(0, 0.04)),
            "wander_mm": 0.005 * np.sqrt(rng.chisquare(25) / 25),
            "wander_df": 28.0,
            "places_mm": {"A": place.tolist(), "B": [place[0] + 500, *place[1:]]},
            "lengths_mm": {"A-B": length},
            "jitters_mm": {},
            "wanders_mm": {},
        }
        of = {"recording": f"t{k}", "source": "measured", "sha256": [str(k)], "moving": False}
        found[f"t{k}"] = of | {"take": take}
    return found


def rows(restart: int = 99) -> list[Row]:
    return [
        Row(f"t{k}", date, "restart" if k == restart else "")
        for k, date in enumerate(DATES, start=1)
    ]


@pytest.mark.usefixtures("undrawn")
def test_a_jump_a_failure_and_a_restart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    every, said = takes(jump_mm=1, at=13), []
    for k in (12, 13, 14, 16):
        if k == 16:
            monkeypatch.undo()  # the last is drawn
        said.append(monitor("hall", rows(restart=16)[:k], every, Settings(), tmp_path))
    assert [one["word"] for one in said] == ["pass", "alert", "failure", "learning"]
    assert [one["valid"] for one in said] == [True, True, False, None]
    assert said[2]["since"] == "2026-03-13"
    assert said[2]["not_valid"] == ["place x"]
    assert said[1]["reasons"][0].startswith("Repeat the take now")
    (changed,) = [one for one in said[2]["findings"] if one["code"] == "place_changed"]
    assert changed["lower_95"] < 1 < changed["upper_95"]
    assert said[3]["restarted"] == "2026-03-16"
    written = json.loads((tmp_path / "monitor.json").read_text())
    assert written["line"] == said[3]["line"]
    table = (tmp_path / "monitor.csv").read_text().splitlines()
    assert len(table) == 1 + 6 * 16
    assert (tmp_path / "chart.png").stat().st_size > 20_000


@pytest.mark.usefixtures("undrawn")
def test_a_return_is_valid_from_its_second_take_on(tmp_path: Path) -> None:
    every = takes(jump_mm=1, at=13)
    for k in (15, 16, 17):
        every[f"t{k}"]["take"]["places_mm"]["A"][0] -= 1
        every[f"t{k}"]["take"]["places_mm"]["B"][0] -= 1
    back, valid = (monitor("hall", rows()[:k], every, Settings(), tmp_path) for k in (15, 16))
    assert (back["word"], back["valid"]) == ("alert", False)
    assert "within the tolerance" in back["reasons"][0]
    assert (valid["word"], valid["valid"], valid["since"]) == ("pass", True, None)


@pytest.mark.usefixtures("undrawn")
def test_a_change_within_the_tolerance_is_a_note(tmp_path: Path) -> None:
    """At once where it is larger than the scatter, else once enough takes have it."""
    grown = monitor("hall", rows()[:18], takes(trend_mm=0.02), Settings(), tmp_path)
    assert grown["word"] == "note"
    assert [one["code"] for one in grown["findings"]] == ["length_changed"]
    every = takes(jump_mm=0.3, at=21)
    said = [monitor("hall", rows()[:k], every, Settings(), tmp_path) for k in range(21, 31)]
    assert {one["word"] for one in said} == {"pass", "note"}
    assert all(one["valid"] for one in said)
    assert any("Place x has moved by +0.3" in one["line"] for one in said)


@pytest.mark.usefixtures("undrawn")
def test_takes_that_are_left_out(tmp_path: Path) -> None:
    every = takes()
    every["t3"]["moving"] = True
    every["t5"]["sha256"] = every["t4"]["sha256"]
    del every["t6"]
    found = monitor("hall", rows()[:8], every, Settings(), tmp_path)
    why = {one["recording"]: one["why"] for one in found["left_out"]}
    assert why.keys() == {"t3", "t5", "t6"}
    assert why["t5"] == "it is the same file as t4"
    assert found["takes"] == 5
    moved = monitor("hall", rows(restart=3)[:8], every, Settings(), tmp_path)
    assert moved["restarted"] == "2026-03-04"
    none = monitor("hall", rows()[2:3], every, Settings(), tmp_path)
    assert none["valid"] is None
    assert "no take could be used" in none["line"]
    assert "no take could be used" in monitor("hall", rows(), {}, Settings(), tmp_path)["line"]


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("at", [3, 4, 5])
def test_a_step_within_the_baseline_is_said(tmp_path: Path, at: int) -> None:
    """Its mean is of neither place, and its scatter hides as much later: nothing is called valid
    before a new baseline."""
    every = takes(jump_mm=1, at=at)
    said = monitor("hall", rows()[:15], every, Settings(), tmp_path)
    assert (said["word"], said["valid"]) == ("note", None)
    (changed,) = [one for one in said["findings"] if one["code"] == "place_changed"]
    assert changed["value"] == pytest.approx(1, abs=0.2)
    assert "Place x changed by" in said["line"] and "baseline was learnt" in said["line"]
    assert "within the tolerance" not in said["line"]
    again = monitor("hall", rows(restart=at)[:15], every, Settings(), tmp_path)
    assert (again["word"], again["valid"]) == ("pass", True)


@pytest.mark.usefixtures("undrawn")
def test_three_places_by_turns_are_no_baseline(tmp_path: Path) -> None:
    """They scatter by more than the tolerance, so that no take is known to be within it."""
    every = takes()
    for k, one in enumerate(every.values()):
        for marker in "AB":
            one["take"]["places_mm"][marker][0] += k % 3
    said = monitor("hall", rows()[:12], every, Settings(), tmp_path)
    assert (said["word"], said["valid"]) == ("note", None)
    assert "Place x scatters by" in said["line"] and "What differs within" in said["line"]


@pytest.mark.usefixtures("undrawn")
def test_a_first_take_unlike_the_others_is_named(tmp_path: Path) -> None:
    every = takes()
    for marker in "AB":
        every["t1"]["take"]["places_mm"][marker][0] += 3
    early, late = (monitor("hall", rows()[:k], every, Settings(), tmp_path) for k in (6, 11))
    assert "t1 is not in the baseline: beyond the tolerance of the other first" in early["line"]
    assert late["word"] == "pass" and "not in the baseline" not in late["line"]


@pytest.mark.usefixtures("undrawn")
def test_values_that_repeat_are_no_take(tmp_path: Path) -> None:
    """A take exported twice, and a stream that stands still, would be as the baseline for ever."""
    every = takes()
    every["t4"]["take"] = every["t3"]["take"]
    every["t6"]["take"]["jitters_mm"] = {"A": 0.02, "B": 0.0}
    said = monitor("hall", rows()[:8], every, Settings(), tmp_path)
    why = {one["recording"]: one["why"] for one in said["left_out"]}
    assert why.keys() == {"t4", "t6"}
    assert "the very places of t3" in why["t4"]
    assert "no value of B changes" in why["t6"]


@pytest.mark.usefixtures("undrawn")
def test_labels_that_were_exchanged_are_left_out_until_a_restart(tmp_path: Path) -> None:
    """Neither the mean place of the markers nor their distance shows them."""
    every = takes()
    for k in (7, 8):
        places = every[f"t{k}"]["take"]["places_mm"]
        places["A"], places["B"] = places["B"], places["A"]
    found = monitor("hall", rows()[:8], every, Settings(), tmp_path)
    assert [one["recording"] for one in found["left_out"]] == ["t7", "t8"]
    assert "A, B stand where B, A stood in the take before" in found["left_out"][0]["why"]
    assert monitor("hall", rows(restart=7)[:8], every, Settings(), tmp_path)["left_out"] == []


def line(number: int, **cells: str) -> Line:
    named = {"recording": f"t{number}", "monitor": "hall", "baseline": "", "markers": "A;B"}
    return Line(number, named | {"date": f"2026-03-{number:02d}", "n_cameras": "8"} | cells)


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        ({"date": "2026-02-28"}, 'column date: "2026-02-28"; expected 2026-03-02 or later'),
        ({"date": ""}, "column date: nothing; expected the date of a take that is monitored"),
        ({"markers": "A;C"}, 'column markers: "A;C"; expected "A;B", as row 2'),
        ({"n_cameras": "7"}, 'column n_cameras: "7"; expected "8", as row 2'),
        ({"monitor": "", "baseline": "yes"}, 'column baseline: "yes"; expected nothing'),
        ({"monitor": "HALL"}, 'column monitor: "HALL"; expected hall, as in the rows before'),
    ],
)
def test_rows_that_do_not_belong_together(cells: dict[str, str], words: str) -> None:
    with pytest.raises(Faults) as faults:
        monitors("s.tsv", [line(2), line(3, **cells)])
    (said,) = faults.value.lines
    assert words in said
    assert said.startswith('s.tsv, row 3 (recording "t3"), ')


@pytest.mark.parametrize(
    ("first", "second", "fits"),
    [
        ("2026-03-02T08:15+01:00", "2026-03-02T07:30Z", True),
        ("2026-03-02T07:30Z", "2026-03-02T08:15+01:00", False),
        ("2026-10-25T02:50+02:00", "2026-10-25T02:10+01:00", True),
        ("2026-03-02T08:15+01:00", "2026-03-02", True),
    ],
)
def test_moments_with_a_zone_are_in_order_of_time(first: str, second: str, fits: bool) -> None:
    said: list[str] = []
    try:
        monitors("s.tsv", [line(2, date=first), line(3, date=second)])
    except Faults as faults:
        said = faults.lines
    assert (not said) == fits


@pytest.mark.usefixtures("undrawn")
def test_a_series_that_is_judged_later_does_not_make_the_facility_learn_again(
    tmp_path: Path,
) -> None:
    """The wander of takes that were too short is learnt after ten takes of the others."""
    every = takes()
    for k in range(1, 12):
        every[f"t{k}"]["take"]["wander_df"] = 7.0
    said = [monitor("hall", rows()[:k], every, Settings(), tmp_path) for k in (13, 18)]
    assert [one["word"] for one in said] == ["pass", "pass"] and said[0]["valid"] is True
    assert "Not judged yet, fewer than 5 takes are learnt: wander." in said[0]["line"]
    every["t18"]["take"]["wander_df"] = 7.0
    short = monitor("hall", rows()[:18], every, Settings(), tmp_path)
    assert "Not judged, as this take is too short: wander." in short["line"]
    assert "Not judged" not in said[1]["line"]


MARKERS = [f"M{k}" for k in range(1, 7)]


def single(noisy: float = 1, moved_mm: float = 0, at: int = 12) -> dict[str, dict[str, Any]]:
    """Takes of six markers; the third one has noise of its own, or is moved, from the twelfth."""
    rng, made = np.random.default_rng(8), takes()
    shape = rng.uniform(-500, 500, (6, 3))
    for k, one in enumerate(made.values(), start=1):
        factors = np.exp(rng.normal(0, 0.02, 6))
        places = shape + rng.normal(0, 0.08, 3) + rng.normal(0, 0.03, (6, 3))
        if k >= at:
            factors[2] *= noisy
            places[2] += moved_mm
        jitter, wander = 0.02 * factors, 0.005 * np.exp(rng.normal(0, 0.1, 6))
        one["take"] |= {
            "jitter_mm": float(np.sqrt(np.mean(jitter**2))),
            "wander_mm": float(np.sqrt(np.mean(wander**2))),
            "places_mm": dict(zip(MARKERS, places.tolist(), strict=True)),
            "lengths_mm": {"M1-M2": float(np.linalg.norm(places[1] - places[0]))},
            "jitters_mm": dict(zip(MARKERS, jitter.tolist(), strict=True)),
            "wanders_mm": dict(zip(MARKERS, wander.tolist(), strict=True)),
        }
    return made


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("change", "series"),
    [({"noisy": 1.6}, {"jitter M3"}), ({"moved_mm": 2.0}, {f"place M3 {a}" for a in "xyz"})],
)
def test_a_single_marker_of_many_fails_by_name(
    tmp_path: Path, change: dict[str, float], series: set[str]
) -> None:
    """1.6 times its noise is 13 % of the noise of all six, less than the 16 % that are allowed."""
    sound = monitor("hall", rows()[:13], single(), Settings(), tmp_path)
    assert sound["word"] == "pass" and sound["markers"] == MARKERS
    assert "Watched: M1, M2, M3, M4, M5, M6; length M1-M2." in sound["line"]
    failed = monitor("hall", rows()[:13], single(**change), Settings(), tmp_path)
    assert failed["word"] == "failure" and set(failed["not_valid"]) == series
    assert "Marker M3 is no longer as it was, since 2026-03-12, unlike the 5" in failed["line"]


def test_many_unchanged_markers_are_hardly_ever_noted() -> None:
    """20 markers, 105 series, 50 takes after the baseline of 10: 5 % are stated; by seeds 1 to 5
    it is 0 to 3 of 40 facilities."""
    how, rng, noted = Settings().monitor, np.random.default_rng(1), 0
    for _ in range(40):
        places = rng.normal(0, 0.1, (60, 1, 3)) + rng.normal(0, 0.05, (60, 20, 3))
        jitter = 0.03 * np.exp(rng.normal(0, 0.05, (60, 1)) + rng.normal(0, 0.01, (60, 20)))
        wander = 0.005 * np.exp(rng.normal(0, 0.08, (60, 20)))
        labels = [f"M{k}" for k in range(20)]
        history = [
            Take(0.03, 0.005, 28.0, dict(zip(labels, p.tolist(), strict=True)), {},
                 dict(zip(labels, j.tolist(), strict=True)),
                 dict(zip(labels, w.tolist(), strict=True)))
            for p, j, w in zip(places, jitter, wander, strict=True)
        ]  # fmt: skip
        judged = judge(history, [str(k) for k in range(60)], [k < 10 for k in range(60)], how)
        words = {word for one in judged for word, _ in one.words[10:]}
        noted += bool(words - {"pass"})
    assert noted <= 5


def test_the_chart_of_many_markers_draws_what_alarms_and_what_is_of_all() -> None:
    names = ["jitter", "wander", "place x", "place y", "place z", "length M1-M2"]
    names += [f"place M{k} {a}" for k in range(1, 41) for a in "xyz"]
    row = {"word": "pass", "value_mm": 1.0, "mean_mm": 1.0, "lower_mm": 0.5, "upper_mm": 1.5}
    rows = [row | {"series": name} for name in names]
    rows[-1] |= {"word": "alert", "value_mm": 3.0}
    rows[40] |= {"value_mm": 1.4}
    drawn, left = _drawn(rows)
    assert left == len(names) - 12 and drawn[:6] == names[:6]
    assert {"place M40 z", names[40]} <= set(drawn)


@pytest.mark.parametrize(("step_mm", "n"), [(0.001, 1500), (0.1, 4000), (0.3, 9000)])
def test_takes_that_are_exported_once_more(step_mm: float, n: int) -> None:
    """From a later frame and in steps up to thrice the noise, of walks in white noise, among takes
    of other days a tenth of that noise apart."""
    rng = np.random.default_rng(n)
    days = [
        rng.normal(0, 0.1, (2, 3, n)) + np.cumsum(rng.normal(0, 0.002, (2, 3, n)), axis=2)
        + rng.normal(0, 0.01, (2, 3, 1))
        for _ in range(8)
    ]  # fmt: skip
    again = np.round(days[5][:, :, n // 5 :] / step_mm) * step_mm
    takes = {
        f"t{k}": {
            "steps": steps_of(day),
            "take": {"places_mm": dict(zip("AB", day.mean(axis=2).tolist(), strict=True))},
        }
        for k, day in enumerate([*days, again])
    }
    noises = Noises(takes)
    for name in [*takes][:-1]:
        assert not noises.repeated(name)
        noises.used.append(name)
    assert "t5" in noises.repeated("t8")
