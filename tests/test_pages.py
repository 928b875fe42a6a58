"""README and pages: what they name is there."""

import re
from pathlib import Path

import pytest
from fetch_samples import read_samples

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / f"{name}.md" for name in ("README", "CONTRIBUTING", "CHANGELOG", "config/README")]
PAGES += sorted((ROOT / "docs").glob("*.md"))
TARGETS = set(re.findall(r"^([a-z0-9-]+):", (ROOT / "Makefile").read_text("utf-8"), re.M))
SAMPLES = {sample.file for sample in read_samples()}


def anchors(page: Path) -> set[str]:
    """Names of the headings, as GitHub and MyST make them."""
    heads = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.M)
    return {re.sub(r"[^\w\- ]", "", head).strip().lower().replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_samples_and_commands_of_a_page_are_there(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\((?!https?:)([^)\s]+)\)", text):
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert file.is_relative_to(ROOT) and file.exists(), target
        assert not anchor or anchor in anchors(file), target
    assert "../shared" not in text
    assert set(re.findall(r"(?<![\w/])samples/([\w./-]+\.\w+)", text)) <= SAMPLES
    assert set(re.findall(r"(?:^    |`|- run: )make ([a-z0-9-]+)", text, re.M)) <= TARGETS


def test_the_readme_takes_five_minutes() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.split()) <= 1200
    assert len(re.findall(r"!\[", text)) == 1
