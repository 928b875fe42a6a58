"""docs/accuracy.md is made of the tables beside it."""

from pathlib import Path

from benchmarks.sentences.__main__ import page


def test_the_page_is_that_of_its_tables():
    """To mend: python -c "import benchmarks.sentences.__main__ as m; print(m.page(), end='')" """
    docs = Path(__file__).parents[1] / "docs"
    assert (docs / "accuracy.md").read_text(encoding="utf-8") == page()
