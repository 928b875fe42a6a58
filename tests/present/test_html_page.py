"""Pages read back by the parser of the standard library: nothing lost, nothing let through."""

from __future__ import annotations

import base64
import itertools
import random
from html.parser import HTMLParser

import pytest

from mocap_metrology.present import tables
from mocap_metrology.present.pages import html_page, markdown_page

VOID = {"br", "wbr", "meta"}


class Reader(HTMLParser):
    """Elements, cells of all tables (or their titles), and links; every tag must be closed."""

    def __init__(self, text: str):
        super().__init__()
        self.open, self.elements, self.links = [], [], []
        self.tables: list[list[list[str]]] = []
        self.cell: str | None = None
        self.title: str | None = None
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.elements.append(tag)
        if tag not in VOID:
            self.open.append(tag)
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])
        elif tag in ("td", "th"):
            self.cell, self.title = "", dict(attrs).get("title")
        elif tag == "a":
            self.links.append(dict(attrs))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag
        if tag in ("td", "th"):
            self.tables[-1][-1].append(self.title or self.cell)
            self.cell = None

    def handle_data(self, data):
        if self.cell is not None:
            self.cell += data


def test_a_table_of_markdown_comes_back_whole() -> None:
    pick = random.Random(3)
    signs = ["a|b", "<script>x</script>", "&amp;", "1 < 2", '"q"', "T_c1", "2;17;19", "", "−3 (×2)"]
    rows = [
        {"name": f"r_{k}", "sign": pick.choice(signs), "value": pick.gauss(0, 1) * 10.0**k, "n": k}
        for k in range(-9, 9)
    ]
    text = tables.markdown(rows, "g: numbers", "A caption <of> these.")
    read = Reader(html_page.page(markdown_page.title_of(text), markdown_page.body_of(text)))
    expected = [["name", "sign", "value", "n"]]
    for row in rows:
        value = f"{row['value']:.7g}"
        expected.append([row["name"], row["sign"], value, str(row["n"])])
    assert read.tables == [expected]
    assert "script" not in read.elements
    assert read.elements.count("h1") == 1


def test_headings_lists_and_bold() -> None:
    text = "# T, Table I: x\n\nOne\ntwo.\n\n## Part\n\n- a\n- **b** c\n\n| a |\n|---|\n| **1** |\n"
    body = markdown_page.body_of(text)
    assert "<p>One two.</p>" in body
    assert "<h2>Part</h2>" in body
    assert "<li>a</li><li><strong>b</strong> c</li>" in body
    assert Reader(body).tables == [[["a"], ["1"]]]


def test_shown_numbers_are_right_to_five_digits() -> None:
    pick = random.Random(4)
    for exponent, _ in itertools.product(range(-12, 6), range(20)):
        text = f"{pick.gauss(0, 1) * 10.0**exponent:.7g}"
        shown = html_page.shortened(text)
        assert float(shown) == pytest.approx(float(text), rel=6e-5)
        assert len(shown.partition("e")[0].lstrip("-").replace(".", "").lstrip("0")) <= 7
    for text in ("1111624858", "72000", "3.14001 (3.13991…3.14011)", "2024-03-01", "1.2.3", ""):
        assert html_page.shortened(text) == text


def test_a_download_is_the_file_itself() -> None:
    content = 'ä,b\n1,"x"\n'.encode()
    link = Reader(html_page.download("t.csv", content, "t.csv")).links[0]
    assert link["download"] == "t.csv"
    assert base64.b64decode(link["href"].partition("base64,")[2]) == content


def luminance(colour: str) -> float:
    """Relative luminance of WCAG 2.1."""
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    r, g, b = (c / 12.92 if c <= 0.03928 else ((c + 0.055) / 1.055) ** 2.4 for c in parts)
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


@pytest.mark.parametrize("ink, behind", [*html_page.WORDS.values(), html_page.UNKNOWN])
def test_verdicts_are_readable(ink: str, behind: str) -> None:
    """Contrast of at least 4.5 (WCAG 2.1, AA)."""
    light, dark = sorted((luminance(ink), luminance(behind)), reverse=True)
    assert (light + 0.05) / (dark + 0.05) >= 4.5
