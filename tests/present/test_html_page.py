"""Pages read back by the parser of the standard library: nothing lost, nothing let through."""

from __future__ import annotations

import random
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from markupsafe import Markup
from matplotlib.figure import Figure as Drawing

from mocap_metrology.common.errors import printable
from mocap_metrology.present import tables
from mocap_metrology.present.pages import details, document, site

VOID = {"br", "wbr", "meta", "img"}


class Reader(HTMLParser):
    """Elements, cells of all tables, links and images; every tag must be closed."""

    def __init__(self, text: str):
        super().__init__()
        self.open, self.elements, self.links, self.images = [], [], [], []
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
        elif tag == "img":
            self.images.append(dict(attrs))

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
    page = document.page(text, "numbers", True)
    read = Reader(page)
    expected = [["name", "sign", "value", "n"]]
    for row in rows:
        sign = row["sign"].replace("T_c1", "Tc1")  # a subscript
        value = tables.readable(row["value"]).replace("-", "−")
        expected.append([row["name"], sign, value, f"{row['n']}".replace("-", "−")])
    assert read.tables == [expected]
    assert read.elements.count("script") == 1  # that of the page
    assert read.elements.count("h1") == 1
    assert read.links[-1]["download"] == "numbers.csv"
    assert read.links[-1]["href"] == "../tables/numbers.csv"
    assert "A caption &lt;of&gt; these." in page


HOSTILE = [
    *("![i](http://127.0.0.1:9/i.png)", "[x](javascript:alert(1))", "<http://127.0.0.1:9/>"),
    *("<img src=http://127.0.0.1:9/ onerror=alert(1)>", "</script><script>alert(1)</script>"),
    *("&lt;b&gt;", "`x`](http://127.0.0.1:9/)", "|</td><iframe src=//127.0.0.1:9/>", "\\![i](a)"),
    *("[r]: http://127.0.0.1:9/", "# T", "\x1b[2J\u202eX", "*x* _y_ __z__"),
]


def test_what_a_user_wrote_is_text(tmp_path: Path) -> None:
    """In a cell, a title and a caption: nothing is loaded, linked or run, and it is read as it was
    written, but for letters that control a terminal."""
    rows = [{"name": words, "comment": words} for words in HOSTILE]
    for words in HOSTILE:
        page = document.page(tables.markdown(rows, f"g: {words}", words), "t", True)
        read = Reader(page)
        assert read.images == [] and read.elements.count("script") == 1
        assert not {"iframe", "object", "embed", "link"} & set(read.elements)
        assert [link["href"] for link in read.links] == ["../summary.html", "../tables/t.csv"]
        assert [row[0] for row in read.tables[0][1:]] == [printable(words) for words in HOSTILE]


def test_a_page_asks_no_host_for_anything() -> None:
    page = document.page("# T\n\n| a |\n|---|\n| 1 |\n", "t", False)
    assert not re.search(r"https?:|//[a-z]|@import|url\(", page.partition("<body")[0])
    assert not re.search(r"<(link|iframe)|\bsrc=|fetch\(|XMLHttpRequest|import\(", page)


def test_headings_lists_bold_and_code() -> None:
    text = "# T, Table I: x\n\nOne\ntwo.\n\n## Part\n\n* a `+`\n* **b** c\n\n"
    text += "| a |\n|---|\n| **1** |\n"  # cells are text
    first, table = document.parts_of(text)
    assert "<h1>T, Table I: x</h1>" in first and "<h2>Part</h2>" in first
    assert "<code>+</code>" in first and "<strong>b</strong> c" in first
    assert table.rows == [[Markup("**1**")]]


@pytest.mark.parametrize(
    ("line", "html"),
    [
        ("h_0 (mm^2/Hz^3)", "h<sub>0</sub> (mm<sup>2</sup>/Hz<sup>3</sup>)"),
        ("h_-2", "h<sub>−2</sub>"),
        ("q_c2 (mm/s^0.5), T_c", "q<sub>c2</sub> (mm/√s), T<sub>c</sub>"),
        ("1 < 2 & 3", "1 &lt; 2 &amp; 3"),
        ("x9_f_0 h_0_b T40-10", "x9_f_0 h_0_b T40-10"),
        ("camera_type", "camera_<wbr>type"),
    ],
)
def test_units_are_typeset(line: str, html: str) -> None:
    assert site.typeset(line) == html


def test_columns_of_numbers_and_of_text() -> None:
    made = site.table(("a", "b", "c", "d"), [("x", "–", "1.5", "w " * 30), ("y", "–", "< 2", "z")])
    assert list(made.kinds) == ["", "n", "n", "t"]
    assert list(site.table(("a", "b"), [("x", "–")], words=(1,)).kinds) == ["", ""]


def test_every_sign_of_a_span_is_a_minus() -> None:
    made = site.table(("a", "b"), [("x", "-0.5…-0.2"), ("y", "0.1…0.2")])
    assert [str(row[1]) for row in made.rows] == ["−0.5…−0.2", "0.1…0.2"]


def test_of_many_columns_the_important_ones_are_seen_first() -> None:
    names = ["camera_type", "n_cameras", *(f"c{k}" for k in range(22)), "published", "verdict"]
    line = "| " + " | ".join(names) + " |"
    text = f"{line}\n{'|---' * len(names)}|\n{line}\n"
    (table,) = document.parts_of(text)
    assert {names[k] for k in table.first} == {"camera_type", "n_cameras", "published", "verdict"}
    assert len(Reader(document.page(text, "t", False)).tables[0][0]) == 26


def test_a_row_without_a_name_has_that_of_the_row_above() -> None:
    """So that rows keep their meaning when they are sorted."""
    (table,) = document.parts_of("| n | a |\n|---|---|\n| 10 | x |\n| | y |\n| 8 | z |\n")
    assert [row[0] for row in table.rows] == ["10", "10", "8"]


def test_names_are_in_natural_order() -> None:
    names = ["noise-10", "noise-2", "Noise-1", "a"]
    assert sorted(names, key=site.natural) == ["a", "Noise-1", "noise-2", "noise-10"]


def test_every_image_has_words_and_leads_to_itself(tmp_path) -> None:
    """Title and caption of the PNG; without one, the name of the file."""
    folder = tmp_path / "recordings" / "r"
    folder.mkdir(parents=True)
    told = {"Title": "r: good", "Description": "One <frame> of y1."}
    for name, metadata in (("verdict", told), ("my_psd", {"Software": None})):
        Drawing(figsize=(1, 1)).savefig(folder / f"{name}.png", metadata=metadata)
    images = [folder / "my_psd.svg", folder / "verdict.svg"]
    figures = details.figures_of(tmp_path, images)
    files = details.files_of(tmp_path, [folder / "noise.csv"])
    page = Reader(details.page("r", figures, files, verdict="good", lines=["It is good."]))
    assert [image["alt"] for image in page.images] == ["r: good. One <frame> of y1.", "my psd"]
    sources = [image["src"] for image in page.images]
    assert sources == ["../../recordings/r/verdict.svg", "../../recordings/r/my_psd.svg"]
    addresses = [link["href"] for link in page.links]
    assert addresses == ["../../summary.html", *sources, "../../recordings/r/noise.csv"]


def test_claims_of_a_paper_are_counted_and_shown() -> None:
    rows = [
        {"paper": paper, "claim": "c", "section": "1", "published": "p", "regenerated": "r"}
        | {"regenerated_word": word}
        for paper, word in (("S", "holds"), ("S", "holds"), ("J", "does not"), ("S", "undecided"))
    ]
    own = details.of_paper(rows, "skurowski")
    assert details.claim_counts(own) == "2 hold, 1 undecided"
    assert details.claim_counts(rows[-1:] + rows) == "2 hold, 1 do not hold, 2 undecided"
    assert details.claim_counts([]) == ""
    assert len(details.claim_table(own).rows) == 3


def luminance(colour: str) -> float:
    """Relative luminance of WCAG 2.1."""
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    r, g, b = (c / 12.92 if c <= 0.03928 else ((c + 0.055) / 1.055) ** 2.4 for c in parts)
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


def contrast(ink: str, behind: str) -> float:
    light, dark = sorted((luminance(ink), luminance(behind)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("ink, behind", site.WORDS.values())
def test_verdicts_are_readable(ink: str, behind: str) -> None:
    """Contrast of at least 4.5 (WCAG 2.1, AA)."""
    assert contrast(ink, behind) >= 4.5


def test_all_text_is_readable() -> None:
    style = site.environment().get_template("style.css").render()
    inks = set(re.findall(r"(?<![-\w])color: (#[0-9a-f]{6})", style)) - {
        ink for ink, _ in site.WORDS.values()
    }
    assert inks
    assert min(contrast(ink, behind) for ink in inks for behind in ("#ffffff", "#f3f4f6")) >= 4.5


def test_own_script_is_short() -> None:
    assert len(site.environment().get_template("page.js").render().splitlines()) <= 150


def test_a_file_is_of_the_group_with_the_longest_name():
    paths = [Path(name) for name in ("lab_adev.svg", "lab_2_adev.svg", "labour_adev.svg")]
    assert details.files_named("lab", ["lab", "lab_2"], paths) == paths[:1]
    assert details.files_named("lab_2", ["lab", "lab_2"], paths) == paths[1:2]
