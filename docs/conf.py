"""The pages of docs/, the manual and the docstrings as a site: `make site`."""

from __future__ import annotations

import os
import re
from pathlib import Path

from sphinx.application import Sphinx

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
# Pages whose text stands elsewhere in the project
ELSEWHERE = {
    "manual": "config/README.md",
    "contributing": "CONTRIBUTING.md",
    "changelog": "CHANGELOG.md",
}
ARRAY = re.compile(
    r"~numpy\.ndarray\[tuple\[~typing\.Any, \.\.\.\], ~numpy\.dtype\[~numpy\.(\w+)\]\]"
)
LINK = re.compile(r"(?<=\]\()([^)#:\s]+)(?=[)#])")

project = "mocap-metrology"
extensions = ["myst_parser", "sphinx.ext.autodoc"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = project
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_show_copyright = False
html_copy_source = False
default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
python_maximum_signature_line_length = 88


def read_page(_app: Sphinx, docname: str, source: list[str]) -> None:
    """Take in the text that stands elsewhere, and lead every link to the page of the site."""
    file = ROOT / ELSEWHERE.get(docname, f"docs/{docname}.md")
    pages = {ROOT / path: name for name, path in ELSEWHERE.items()} | {ROOT / "README.md": "index"}

    def lead(link: re.Match[str]) -> str:
        target = (file.parent / link[0]).resolve()
        if target in pages:
            return f"{pages[target]}.md"
        return os.path.relpath(target, DOCS)

    source[0] = LINK.sub(lead, file.read_text(encoding="utf-8"))


def read_docstring(_app: Sphinx, _what: str, _name: str, _o: object, _s: object, lines: list[str]):
    """Docstrings are plain text with `code`, **bold** and indented formulas."""
    text = "\n".join(lines)
    paragraphs = []
    for paragraph in re.split(r"\n\s*\n", text.strip("\n")):
        if all(line.startswith("    ") for line in paragraph.splitlines()):
            paragraphs.append("::\n\n" + paragraph)
            continue
        parts = re.split(r"(`[^`]+`|\*\*[^*]+\*\*)", " ".join(paragraph.split()))
        parts[::2] = [re.sub(r"([\\*|_`])", r"\\\1", part) for part in parts[::2]]
        paragraphs.append(re.sub(r"(?<=[^\s(\\]`)(?=\w)", r"\\ ", "".join(parts)))
    lines[:] = [*"\n\n".join(paragraphs).splitlines(), ""]


def read_signature(
    _app: Sphinx,
    _what: str,
    _name: str,
    _o: object,
    _s: object,
    given: str | None,
    back: str | None,
) -> tuple[str, str | None] | None:
    """Arrays as they stand in the source."""
    if given is None:
        return None
    return ARRAY.sub(r"NDArray[\1]", given), back and ARRAY.sub(r"NDArray[\1]", back)


def setup(app: Sphinx) -> None:
    app.connect("source-read", read_page)
    app.connect("autodoc-process-docstring", read_docstring)
    app.connect("autodoc-process-signature", read_signature)
