"""Pages read back by the parser of the standard library: nothing lost, nothing let through."""

from __future__ import annotations

import base64
import random
from html.parser import HTMLParser

import pytest

from mocap_metrology.present import tables
from mocap_metrology.present.drawing.style import UNKNOWN_WORD, VERDICT_WORDS
from mocap_metrology.present.pages import html_page

VOID = {"br", "wbr", "meta"}


class Reader(HTMLParser):
    """Elements, cells of all tables, and links; every tag must be closed."""

    def __init__(self, text: str):
        super().__init__()
        self.open, self.elements, self.links = [], [], []
        self.tables: list[list[list[str]]] = []
        self.cell: str | None = None
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
            self.cell = ""
        elif tag == "a":
            self.links.append(dict(attrs))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag
        if tag in ("td", "th"):
            self.tables[-1][-1].append(self.cell)
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
    read = Reader(html_page.page(html_page.title_of(text), html_page.body_of(text)))
    expected = [["name", "sign", "value", "n"]]
    for row in rows:
        value = tables.readable(row["value"])
        sign = row["sign"].replace("T_c1", "Tc1")  # a subscript
        expected.append(
            [row["name"], sign, value.replace("-", "−"), f"{row['n']}".replace("-", "−")]
        )
    assert read.tables == [expected]
    assert "script" not in read.elements
    assert read.elements.count("h1") == 1


def test_headings_lists_and_bold() -> None:
    text = "# T, Table I: x\n\nOne\ntwo.\n\n## Part\n\n- a\n- **b** c\n\n| a |\n|---|\n| **1** |\n"
    body = html_page.body_of(text)
    assert "<p>One two.</p>" in body
    assert "<h2>Part</h2>" in body
    assert "<li>a</li><li><strong>b</strong> c</li>" in body
    assert Reader(body).tables == [[["a"], ["1"]]]


@pytest.mark.parametrize(
    ("line", "html"),
    [
        ("`same` or `a_b`", "<code>same</code> or <code>a_<wbr>b</code>"),
        ("`2e-07 mm^2` **h_-2**", "<code>2e-07 mm^2</code> <strong>h<sub>−2</sub></strong>"),
        ("9.26 (9.10…9.40)e-07", "9.26 (9.10…9.40)×10<sup>−7</sup>"),
        ("< 1e-6, 1.00e+05", "&lt; 10<sup>−6</sup>, 1.00×10<sup>5</sup>"),
        ("h_0 (mm^2/Hz^3)", "h<sub>0</sub> (mm<sup>2</sup>/Hz<sup>3</sup>)"),
        ("mm^2 Hz", "mm<sup>2</sup>\u00a0Hz"),
        ("q_c2 (mm/s^0.5), T_c", "q<sub>c2</sub> (mm/\u2060√s), T<sub>c</sub>"),
        ("h_0_b x9_f_0 T40-10 3e4b1 v1.2e-3x a1e-05", "h_0_b x9_f_0 T40-10 3e4b1 v1.2e-3x a1e-05"),
    ],
)
def test_code_units_and_powers_of_ten(line: str, html: str) -> None:
    assert html_page.inline(line) == html


def test_lists_of_both_signs() -> None:
    body = html_page.body_of("Text.\n* a `+`\n* b\n\n**c** d\n")
    assert body.split("\n")[1] == "<ul><li>a <code>+</code></li><li>b</li></ul>"
    assert body.endswith("<p><strong>c</strong> d</p>")


def test_a_column_of_dashes_stands_where_its_numbers_would() -> None:
    text = html_page.table(("a", "b", "c"), [("x", "–", ""), ("y", "–", "")])
    assert text.count('<td class="n">–</td>') == 2
    assert text.count('class="n"') == 3
    assert 'class="n"' not in html_page.table(("a", "b"), [("x", "–")], words=(1,))


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


@pytest.mark.parametrize("ink, behind", [*VERDICT_WORDS.values(), UNKNOWN_WORD])
def test_verdicts_are_readable(ink: str, behind: str) -> None:
    """Contrast of at least 4.5 (WCAG 2.1, AA)."""
    light, dark = sorted((luminance(ink), luminance(behind)), reverse=True)
    assert (light + 0.05) / (dark + 0.05) >= 4.5
