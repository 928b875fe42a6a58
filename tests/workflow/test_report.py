"""`make report`: a report that opens by itself in a browser, and shows what was found."""

from __future__ import annotations

import csv
import html
import json
import re
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from browser import NAMES, browser
from laboratory import ACTIVE
from mocap_workflow import report
from running import command, environment

from mocap_metrology.present.pages import summary

ROOT = Path(__file__).resolve().parents[2]
PLAIN = command()[3:]


def write_report(folder: Path, *arguments: str) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, ROOT / "workflow/write_report.py", "results/report.html", *arguments],
        cwd=folder,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=900,  # as that of Snakemake
    )


@pytest.fixture(scope="module")
def made(run) -> tuple[Path, str]:
    """Folder of the run over everything with its report, and what was said of it."""
    written = write_report(run.folder, *PLAIN, *run.arguments)
    assert written.returncode == 0, written.stdout
    return run.folder, written.stdout


@pytest.fixture(scope="module")
def executable() -> str:
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.skip("no Chromium or Chrome in PATH")
    return found


READY = "document.querySelector('#app')?.innerText"
SHOW = """(() => {
  const result = results[%s];
  const content = result.mime_type === "text/html" ? "html" : "img";
  document.addEventListener("load", event => { window.loaded = event.target.src; }, true);
  app.setView({content, contentPath: result.data_uri, resultPath: %s});
})()"""
SHOWN = """(() => {
  const result = results[%s];
  const html = result.mime_type === "text/html";
  const shown = document.querySelector(html ? "iframe" : "#app div.p-3 > img");
  const there = html ? window.loaded === result.data_uri : shown?.naturalWidth > 0;
  return shown?.src === result.data_uri && there;
})()"""
# Left and top edge of the title in its page, as scrolled to the top, and its width
TITLE = """(() => {
  const title = document.querySelector(".prose h1"), page = title.closest(".overflow-auto");
  page.scrollTo(0, 0);
  const {left, top, right} = title.getBoundingClientRect();
  return [left - page.getBoundingClientRect().left, top, right - left];
})()"""
ACTIVE_LINKS = """[...document.querySelectorAll("a, iframe, object, embed")].filter(element =>
  /^(javascript|http)/.test(element.href || element.src || element.data)).length"""
LINKS = "[...document.querySelectorAll('.mm a')].map(a => [a.textContent, a.getAttribute('href')])"


def test_opens_without_error_or_network(made, executable, tmp_path) -> None:
    folder, said = made
    assert re.fullmatch(r"results/report\.html: \d+\.\d MB\n", said)
    page = folder / "results/report.html"
    with browser(executable, tmp_path) as seen:
        seen.open(page.as_uri(), READY)
        front = seen.until("document.querySelector('#app').innerText")
        shown = seen.until("Object.keys(results)")
        for path in map(json.dumps, shown):
            seen.evaluate(SHOW % (path, path))
            seen.until(SHOWN % path)
        seen.open(page.as_uri(), f"{READY} && {LINKS}.length")
        links = dict(seen.evaluate(LINKS))
        menu = seen.until("document.querySelector('nav').innerText").split("\n")
        titles = []
        for width, height in ((1400, 900), (400, 800)):
            seen.size(width, height)
            titles.append(seen.evaluate(TITLE))
    assert seen.errors == []
    assert {url.partition(":")[0] for url in seen.requests} == {"data", "file"}
    assert {url for url in seen.requests if url.startswith("file")} == {page.as_uri()}
    for left, top, _ in titles:  # beside the menu, and not above or left of what can be reached
        assert 0 <= left < 30 and 0 <= top < 60
    assert titles[0][2] > 1000 and titles[1][2] > 300
    for words in ("How good is", "hall: recordings", "lab: calibrations", "zip", "refused"):
        assert words in front
    assert links["take"] == "details/recordings/take.html"
    assert links["measured"] == "details/calibrations/measured.html"
    assert all((page.parent / path).is_file() for path in links.values())
    assert {Path(path).suffix for path in shown} == {".html", ".svg"}
    listed = [line.strip() for line in menu if line.strip() in report.CATEGORIES]
    assert listed == [name for name in report.CATEGORIES if name in listed]
    assert listed[0] == "1 Summary"
    assert listed[-1] == "7 Provenance"


def test_no_label_cell_or_file_name_asks_a_host_or_runs_in_a_page(
    made, executable, tmp_path
) -> None:
    """Nor is it a formula in a table, or a signal to a terminal."""
    folder, _ = made
    pages = sorted((folder / "results").rglob("*.html"))
    assert {"summary.html", "active.html", "hall_subsets.html"} <= {page.name for page in pages}
    with browser(executable, tmp_path) as seen:
        for page in pages:
            seen.requests.clear()
            seen.open(page.as_uri(), "document.body")
            assert not [url for url in seen.requests if not url.startswith(("file:", "data:"))]
            assert not seen.evaluate(ACTIVE_LINKS), page
            assert seen.errors == [] and seen.dialogs == [], page
    text = (folder / "results/details/recordings/active.html").read_text(encoding="utf-8")
    assert html.escape(ACTIVE[0]) in text
    for path in (folder / "results").rglob("*.csv"):
        cells = [cell for row in csv.reader(path.open(encoding="utf-8")) for cell in row]
        assert not [cell for cell in cells if cell.startswith("=")], path


def test_no_cell_of_a_sheet_is_markup_in_the_data_of_the_report() -> None:
    """As Snakemake writes it: parameters of jobs, a sheet's cells among them, as JSON."""
    cell = "</script><img src=x onerror=alert(1)><!-- ; var x = 1;"
    params = f"rows=[{{'camera_type': '{cell}'}}]"
    metadata = import_module(f"{report.REPORTER}.data.metadata")
    report.without_markup()
    text = metadata.render_metadata({"params": params})
    assert "<" not in text
    assert json.loads(text) == {"params": params}


def test_no_result_is_markup_in_the_report(made) -> None:
    """The data of a finished report are those that Snakemake wrote, without a tag."""
    text = (made[0] / "results/report.html").read_text(encoding="utf-8")
    for name in ("results", "rules", "categories", "metadata", "workflow_desc"):
        (data,) = re.findall(rf'<script id="[\w-]+">\s*var {name} = (.*);\n', text)
        json.loads(data)
        assert "<" not in data


def test_pages_and_provenance(made) -> None:
    folder, _ = made
    results = folder / "results"
    found = json.loads((results / "provenance.json").read_text())
    tables = {path.name for path in (results / "tables").glob("*.csv")}
    assert set(found["tables"]) == tables
    assert {path.stem for path in (results / "pages").glob("*.html")} == {
        Path(name).stem for name in tables
    }
    inputs = {row["name"]: row for row in found["inputs"]}
    twin, calibration = inputs["T40-10"], inputs["twin"]
    assert (twin["name"], twin["source"], twin["seed"]) == ("T40-10", "twin", 110)
    assert calibration["source"] == "twin"
    rules = {row["rule"]: row["jobs"] for row in found["run_times"]}
    assert (rules["noise"], rules["calibration_twins"]) == (5, 1)
    for name in ("provenance.json", "provenance.html", "summary.html", "report_front.html"):
        text = (results / name).read_text()
        assert str(folder) not in text, name
        assert str(ROOT) not in text, name


def test_an_unfinished_run_is_one_line(made, run) -> None:
    figure = run.results / "calibrations/measured/calibration.svg"
    kept = figure.rename(figure.with_suffix(".kept"))
    try:
        said = write_report(run.folder, *PLAIN, *run.arguments)
    finally:
        kept.rename(figure)
    assert said.returncode == 1
    missing = "results/calibrations/measured/calibration.svg is missing"
    assert said.stdout.count("\n") == 1 and said.stdout.startswith(f"no report: {missing}")


@pytest.mark.parametrize(
    "title, expected",
    [
        (
            "Jansen et al. 2019, Table I: mean absolute error",
            ("3 Jansen et al. 2019", None, "Table I: mean absolute error"),
        ),
        (
            "Skurowski & Pawlyta 2019, Tables A1-A3: white noise: given back",
            ("2 Skurowski & Pawlyta 2019", None, "Tables A1-A3: white noise: given back"),
        ),
        (
            "Left out: figures of both papers that are not regenerated",
            ("7 Provenance", None, "Left out: figures of both papers that are not regenerated"),
        ),
        ("hall.1: outliers", ("4 Groups", "hall.1", "table: outliers")),
        ("whatever", ("4 Groups", None, "table: whatever")),
    ],
)
def test_titles_of_tables_say_where_they_go(tmp_path, title: str, expected: tuple) -> None:
    path = tmp_path / "table.md"
    path.write_text(f"# {title}\n\nText.\n")
    found = report.entry(str(path))
    shown = found["category"], found["subcategory"], found["labels"]["result"]
    assert shown == expected


def test_pages_name_categories_that_there_are() -> None:
    named = re.findall("“(.+?)”", summary.INSIDE)
    assert named and set(named) <= set(report.CATEGORIES)


def test_rules_name_numbered_categories_and_offer_no_table_twice() -> None:
    """A report could only offer a CSV for download, which lies beside it; it shows its page."""
    for path in (ROOT / "workflow/rules").glob("*.smk"):
        text = path.read_text(encoding="utf-8")
        assert set(re.findall(r'\bcategory="(.+)"', text)) <= set(report.CATEGORIES), path
        assert not re.search(r'report\(\s*f?"[^"]+\.csv"', text), path
