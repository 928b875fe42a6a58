"""Pages read back by the parser of the standard library: nothing lost, nothing let through."""

import random
import re
from html.parser import HTMLParser
from pathlib import Path

from matplotlib.figure import Figure as Drawing

from mocap_metrology.common.errors import printable
from mocap_metrology.present import tables
from mocap_metrology.present.pages import details

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
    page = details.table_page(text, "numbers", True)
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
        page = details.table_page(tables.markdown(rows, f"g: {words}", words), "t", True)
        read = Reader(page)
        assert read.images == [] and read.elements.count("script") == 1
        assert not {"iframe", "object", "embed", "link"} & set(read.elements)
        assert [link["href"] for link in read.links] == ["../summary.html", "../tables/t.csv"]
        assert [row[0] for row in read.tables[0][1:]] == [printable(words) for words in HOSTILE]
    page = details.table_page("# T\n\n| a |\n|---|\n| 1 |\n", "t", False)  # nor asks it any host
    assert not re.search(r"https?:|//[a-z]|@import|url\(", page.partition("<body")[0])
    assert not re.search(r"<(link|iframe)|\bsrc=|fetch\(|XMLHttpRequest|import\(", page)
    page = Reader(
        details.page(HOSTILE[3], csv=[Path(HOSTILE[3])], verdict=HOSTILE[4], lines=HOSTILE)
    )
    assert page.images == [] and page.elements.count("script") == 1


def test_every_image_has_words_and_leads_to_itself(tmp_path) -> None:
    """Title and caption of the SVG; without one, the name of the file. Tables of groups and papers
    have a page; a measured subject without a figure says so."""
    folder = tmp_path / "recordings" / "r"
    folder.mkdir(parents=True)
    told = {"Title": "r: good", "Description": "One <frame> of y1."}
    for name, metadata in (("verdict", told), ("my_psd", {})):
        Drawing(figsize=(1, 1)).savefig(folder / f"{name}.svg", metadata=metadata)
    figures = details.figures_of(tmp_path, [folder / "my_psd.svg", folder / "verdict.svg"])
    csv = [Path("tables/r_10.csv"), Path("recordings/r/noise.csv"), Path("tables/r_2.csv")]
    page = Reader(details.page("r", figures, csv, verdict="good", lines=["It is good."]))
    assert [image["alt"] for image in page.images] == ["r: good. One <frame> of y1.", "my psd"]
    sources = [f"../../recordings/r/{name}.svg" for name in ("verdict", "my_psd")]
    assert [image["src"] for image in page.images] == sources
    tables = [
        f"../../{name}" for of in (2, 10) for name in (f"tables/r_{of}.csv", f"pages/r_{of}.html")
    ]
    addresses = ["../../summary.html", *sources, "../../recordings/r/noise.csv", *tables]
    assert [link["href"] for link in page.links] == addresses
    assert details.UNDRAWN in details.page("r", verdict="good")
    assert details.UNDRAWN not in details.page("r")
