"""What every rule says of itself."""

from __future__ import annotations

import re


def rules(root) -> dict[str, str]:
    """Text of each rule that runs a script, by name."""
    texts = [path.read_text(encoding="utf-8") for path in (root / "workflow/rules").glob("*.smk")]
    found = re.findall(r"^(?:rule|checkpoint) (\w+):\n((?: .*\n|\n(?= ))+)", "\n".join(texts), re.M)
    return {name: body for name, body in found if "    script:" in body}


def test_every_rule_says_what_it_needs_and_where_it_tells(root) -> None:
    found = rules(root)
    assert len(found) > 40
    for name, body in found.items():
        assert re.search(r"^        mem_mb=memory\(\d+(, arrays=\d+)?\),$", body, re.M), name
        assert re.search(r"^        runtime=minutes\(\d+\),$", body, re.M), name
        for directive in ("log", "benchmark", "message"):
            assert f"    {directive}:\n" in body, (name, directive)
        assert "threads:" not in body, f"{name}: one thread, so that --cores changes no byte"
