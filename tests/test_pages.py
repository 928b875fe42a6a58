"""README and pages: what they name is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from fetch_samples import read_samples

ROOT = Path(__file__).resolve().parents[1]
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "config/README.md")),
    *sorted((ROOT / "docs").glob("*.md")),
]
NAMES = [str(page.relative_to(ROOT)) for page in PAGES]


def anchors(page: Path) -> set[str]:
    """Names of the headings, as GitHub and MyST make them."""
    heads = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.M)
    return {re.sub(r"[^\w\- ]", "", head).strip().lower().replace(" ", "-") for head in heads}


@pytest.mark.parametrize("name", NAMES)
def test_links_lead_to_files_and_headings_of_the_project(name: str) -> None:
    page = ROOT / name
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if re.match(r"https?:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert file.is_relative_to(ROOT) and file.exists(), target
        assert not anchor or anchor in anchors(file), target


@pytest.mark.parametrize("name", NAMES)
def test_no_path_leads_out_of_the_project(name: str) -> None:
    text = (ROOT / name).read_text(encoding="utf-8")
    assert "../shared" not in text
    listed = {sample.file for sample in read_samples()}
    named = set(re.findall(r"(?<![\w/])samples/([\w./-]+\.\w+)", text))
    assert named <= listed


@pytest.mark.parametrize("name", NAMES)
def test_commands_of_make_are_there(name: str) -> None:
    targets = set(
        re.findall(r"^([a-z0-9-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M)
    )
    text = (ROOT / name).read_text(encoding="utf-8")
    assert set(re.findall(r"(?:^    |`|- run: )make ([a-z0-9-]+)", text, re.M)) <= targets


def test_the_readme_takes_five_minutes() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.split()) <= 1200
    assert len(re.findall(r"!\[", text)) == 1
