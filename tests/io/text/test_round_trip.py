"""Written and read: the same numbers, in every format and in every form that programs give it."""

from dataclasses import dataclass
from unittest import mock

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from text_files import WRITERS, make, read

from mocap_metrology.io.read import labels_of
from mocap_metrology.io.text import rows

LABELS = ("Fuß", "Knöchel", "C7")
MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "Meters": 1000.0, "millimetre": 1.0}
MARKS = {".trc": "\t,;", ".nexus.csv": ",;", ".table.csv": ",;\t ", ".motive.csv": ","}
SUFFIXES = {".trc": [".trc"], ".tsv": [".tsv"], ".fp.tsv": [".tsv", ".xls"]}
SUFFIXES[".table.csv"] = [".csv", ".tsv", ".txt", ".tum"]


@dataclass
class Export:
    """A recording (n, k, 3) in mm, NaN in its gaps, and what a program made of it."""

    kind: str
    take: np.ndarray
    rate: float
    unit: str
    digits: int
    first: int
    kept: np.ndarray
    zeros: bool
    suffix: str
    text: str


@st.composite
def exports(draw, kind: str) -> Export:
    n, k = draw(st.integers(8, 30)), draw(st.integers(1, 3))
    seed, digits = draw(st.integers(0, 999)), draw(st.integers(3, 6))
    rate = draw(st.sampled_from([25, 59.94, 100, 119.88, 250]))
    unit = "mm" if kind == ".tsv" else draw(st.sampled_from(["mm", "cm", "m"]))
    if kind == ".motive.csv":
        unit = {"m": "Meters", "mm": "millimetre"}.get(unit, unit)
    rng = np.random.default_rng(seed)
    take = rng.normal(0, 0.3, (n, k, 3)) + rng.uniform(-3000, 3000, (k, 3))
    scaled = np.round(take / MM[unit], digits)
    gap_at = rng.random((n, k)) < draw(st.sampled_from([0.0, 0.3]))
    gap_at[0, -1] = gap_at[-1] = False  # a first row without numbers shows no columns
    gap_at[:2, 1:] &= kind != ".table.csv"
    scaled[gap_at] = np.nan
    options, first, zeros = {}, 1, False
    mark = draw(st.sampled_from(MARKS.get(kind, "\t")))
    blank = draw(st.sampled_from(["", "", " ", "   ", " NULL", "NaN  "]))
    if kind in (".trc", ".motive.csv", ".nexus.csv"):
        options["first"] = first = draw(st.sampled_from([1, 0, 101]))
    if kind == ".tsv":
        options |= {"gap": draw(st.sampled_from(["0.000", "", "NULL", "NaN"]))}
        options |= {"leading": draw(st.integers(0, 2)), "titles": draw(st.booleans())}
        zeros = options["gap"] == "0.000"
    elif unit:
        options["unit"] = unit
    if kind == ".table.csv":
        options |= {"time_digits": 7, "gap": "NaN" if mark == " " else ""}
    lines = WRITERS[kind](LABELS[:k], rate, scaled, digits=digits, **options).splitlines()
    numbered = kind != ".tsv" or options["leading"] > 0
    kept = np.ones(n, bool)
    if numbered:  # rows that are missing: a frame number or a time says so
        kept[draw(st.lists(st.integers(2, n - 2), max_size=n // 4))] = False
    head = [line.replace("\t" if kind == ".trc" else ",", mark) for line in lines[:-n]]
    if kind in (".tsv", ".fp.tsv", ".motive.csv"):
        head = lines[:-n]
    if mark == " ":
        head = [line.replace(" [", "_").replace("]", "") for line in head]
        blank = ""
    own = "\t" if kind in (".trc", ".tsv", ".fp.tsv") else ","
    body = [line.split(own) for line, there in zip(lines[-n:], kept, strict=True) if there]
    width = draw(st.sampled_from([0, 0, 16]))
    point = "," if mark != "," and draw(st.booleans()) else "."
    end_early = kind in (".trc", ".motive.csv", ".nexus.csv") and draw(st.booleans())
    for i, cells in enumerate(body):
        last = len(cells) if cells[-1] or kind not in (".trc", ".fp.tsv") else len(cells) - 1
        cells = [cell.replace(".", point) or blank for cell in cells[:last]]
        body[i] = mark.join(f"{cell:>{width}} " if width else cell for cell in cells)
        if end_early and i:
            body[i] = body[i].rstrip(mark)
    if (mark != "\t" and kind == ".trc") or (kind == ".nexus.csv" and draw(st.booleans())):
        most = 1 + 3 * k  # as a spreadsheet saves it: as many delimiters in every line
        head = [line.rstrip(mark) for line in head]
        head = [line + mark * (most - line.count(mark)) for line in head]
    ends = draw(st.sampled_from(["\n", "\r\n"]))
    text = ends.join([*head, *body]) + draw(st.sampled_from([ends, ends, ""]))
    suffix = draw(st.sampled_from(SUFFIXES.get(kind, [".csv"])))
    shown = np.where(kept[:, None, None], scaled * MM[unit], np.nan)
    return Export(kind, shown, rate, unit, digits, first, kept, zeros, suffix, text)


@pytest.mark.parametrize("kind", WRITERS)
@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_every_form_of_a_format_gives_the_numbers_that_were_written(tmp_path, kind, data) -> None:
    export = data.draw(exports(kind))
    encoding = data.draw(st.sampled_from(["utf-8", "utf-8-sig", "latin-1"]))
    path = make(tmp_path, f"a{export.suffix}", export.text, encoding)
    n, k, _ = export.take.shape
    block = data.draw(st.sampled_from([97, 1000, rows.BLOCK_BYTES]))
    with mock.patch.object(rows, "BLOCK_BYTES", block):
        recording = read(path, LABELS[:k])
    assert labels_of(path) == LABELS[:k] == recording.labels
    expected = export.take.transpose(1, 2, 0)
    tolerance = {"rtol": 1e-14, "atol": 0, "equal_nan": True}
    np.testing.assert_allclose(recording.position_mm, expected, **tolerance)
    assert recording.frame_rate_hz == pytest.approx(export.rate, rel=1e-5)
    assert (recording.units, recording.unit_source) == (export.unit, "file")
    assert recording.resolution_mm == pytest.approx(10.0**-export.digits * MM[export.unit])
    assert recording.resolution_kind == "text"
    assert recording.n_gap_frames == n - export.kept.sum()
    empty = np.isnan(export.take[export.kept]).all(axis=2).sum(axis=0)
    reason = "zero" if export.zeros else "empty"
    assert [found[reason] for found in recording.n_invalid] == empty.tolist()
    assert sum(sum(found.values()) for found in recording.n_invalid) == empty.sum()
    assert recording.segments[0].n_frames == n
    assert recording.segments[0].first_frame == export.first
    unfinished = not export.text.endswith("\n")
    assert any("the last, has no line end" in note for note in recording.notes) == unfinished
    assert any("frames are missing in" in note for note in recording.notes) == (
        not export.kept.all()
    )
