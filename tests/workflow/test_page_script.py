"""Pages in a browser: tables sort and are searched, figures zoom, nothing is wider than a phone."""

import base64

import pytest
from browser import browser
from matplotlib.figure import Figure as Drawing

from mocap_metrology.present.pages import details, summary
from mocap_metrology.present.text import captions

COLUMN = "[...document.querySelectorAll('tbody tr:not([hidden])')].map(r => r.cells[%d].innerText)"
CLICK = "document.querySelectorAll('thead button')[%d].click()"
SEARCH = """(() => {
  const search = document.querySelector("input[type=search]");
  search.value = "noise-1 s";
  search.dispatchEvent(new Event("input"));
})()"""
SCALE = "new DOMMatrix(getComputedStyle(document.querySelector('dialog img')).transform).a"
WHEEL = """document.querySelector("dialog").dispatchEvent(
  new WheelEvent("wheel", {deltaY: -400, clientX: 300, clientY: 200}))"""
WIDTH = "document.documentElement.scrollWidth"
# From the end of the text before each index to the index
GAPS = """[...document.querySelectorAll(".cards sub, .cards sup")].map(index => {
  const before = document.createRange();
  before.selectNode(index.previousSibling);
  const ends = [...before.getClientRects()].at(-1), own = index.getBoundingClientRect();
  return Math.abs(own.left - ends.right) + (own.top > ends.bottom || own.bottom < ends.top) * 100;
})"""
VALUES = ("9.26×10⁻⁷", "−5.20", "", "13\u202f195", "< 0.3", "2.5 (2.1…2.9)", "–", "7", "12")


def test_a_table_sorts_by_number_and_name_and_is_searched(executable, tmp_path) -> None:
    rows = [f"| noise-{len(VALUES) - k} | {value} | s{k} |" for k, value in enumerate(VALUES)]
    wide = " | ".join(f"column_{k}" for k in range(20))
    text = "\n".join(["# T", "", "| name | value | s |", "|---|---|---|", *rows, "", f"| {wide} |"])
    text += "\n" + "|---" * 20 + "|\n"
    page = tmp_path / "page.html"
    page.write_text(details.table_page(text, "t", False), encoding="utf-8")
    with browser(executable, tmp_path) as seen:
        seen.size(400, 800)
        seen.open(page.as_uri(), "document.querySelector('thead button')")
        assert seen.evaluate(WIDTH) <= 400
        seen.evaluate(CLICK % 1)
        rising = seen.evaluate(COLUMN % 1)
        seen.evaluate(CLICK % 1)
        falling = seen.evaluate(COLUMN % 1)
        seen.evaluate(CLICK % 0)
        names = seen.evaluate(COLUMN % 0)
        seen.evaluate(SEARCH)
        left = seen.evaluate(COLUMN % 0)
        assert seen.errors == []
        assert seen.requests == [page.as_uri()]
    numbers = ["−5.20", "9.26×10⁻⁷", "< 0.3", "2.5 (2.1…2.9)", "7", "12", "13\u202f195"]
    assert [value for value in rising if value not in ("", "–")] == numbers
    assert [value for value in falling if value not in ("", "–")] == numbers[::-1]
    assert set(rising[-2:]) == set(falling[-2:]) == {"", "–"}
    assert names == [f"noise-{k}" for k in range(1, len(VALUES) + 1)]
    assert left == ["noise-1"]


def test_on_a_phone_an_index_is_beside_its_letter(executable, tmp_path) -> None:
    row = {"claim": "h_-2 is in mm^2 Hz", "published": "h_-2", "regenerated": "mm^2/Hz"}
    row |= {"regenerated_word": "holds", "section": "1", "paper": "S"}
    claims = details.claim_table([row])
    page = tmp_path / "page.html"
    given = [{"title": "Claims", "table": claims}]
    page.write_text(details.page("T", [], [], tables=given), encoding="utf-8")
    with browser(executable, tmp_path) as seen:
        seen.size(400, 800)
        seen.open(page.as_uri(), "document.querySelector('sub, sup')")
        gaps = seen.evaluate(GAPS)
    assert len(gaps) == 4
    assert max(gaps) < 2  # pixels


def test_without_an_address_a_page_names_where_things_are(executable, tmp_path) -> None:
    """Snakemake's report shows pages as data: there a link leads nowhere."""
    table = details.table_page("# T\n\n| a |\n|---|\n| 1 |\n", "t", True)
    front = summary.page(summary.Verdicts(), tables=["t"])
    with browser(executable, tmp_path) as seen:
        for text in (table, front):
            address = f"data:text/html;base64,{base64.b64encode(text.encode()).decode()}"
            seen.open(address, "document.querySelector('h1')")
            assert not seen.evaluate("document.querySelectorAll('a, nav').length")
            said = seen.evaluate("document.body.innerText")
            expected = "tables/t.csv, beside this report: all" if text is table else captions.MENU
            assert expected in said
        page = tmp_path / "page.html"
        page.write_text(front, encoding="utf-8")
        seen.open(page.as_uri(), "document.querySelector('h1')")
        assert captions.MENU not in seen.evaluate("document.body.innerText")


def test_a_figure_opens_and_zooms(executable, tmp_path) -> None:
    folder = tmp_path / "recordings" / "r"
    folder.mkdir(parents=True)
    for end in ("png", "svg"):
        Drawing(figsize=(6, 4)).savefig(folder / f"verdict.{end}")
    page = tmp_path / details.address("recording", "r")
    page.parent.mkdir(parents=True)
    figures = details.figures_of(tmp_path, [folder / "verdict.svg"])
    page.write_text(details.page("r", figures, [], verdict="good"), encoding="utf-8")
    with browser(executable, tmp_path) as seen:
        seen.open(page.as_uri(), "document.querySelector('figure img').naturalWidth")
        seen.evaluate("document.querySelector('figure a').click()")
        assert seen.evaluate("document.querySelector('dialog').open")
        assert seen.evaluate(SCALE) == 1
        seen.evaluate(WHEEL)
        assert seen.evaluate(SCALE) == pytest.approx(2.718, abs=0.01)
        assert seen.evaluate("location.pathname").endswith("details/recordings/r.html")
        assert seen.errors == []
