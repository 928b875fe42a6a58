"""What every rule says of itself."""

from __future__ import annotations

import math
import re
from types import SimpleNamespace


def rules(root) -> dict[str, str]:
    """Text of each rule that runs a script, by name."""
    texts = [path.read_text(encoding="utf-8") for path in (root / "workflow/rules").glob("*.smk")]
    found = re.findall(r"^(?:rule|checkpoint) (\w+):\n((?: .*\n|\n(?= ))+)", "\n".join(texts), re.M)
    return {name: body for name, body in found if "    script:" in body}


def test_every_rule_says_what_it_needs_and_where_it_tells(root) -> None:
    found = rules(root)
    assert len(found) > 30
    for name, body in found.items():
        assert re.search(r"^        mem_mb=memory\(\d+(, arrays=\d+)?\),$", body, re.M), name
        assert re.search(r"^        runtime=minutes\(\d+(, seconds=[\d.]+)?\),$", body, re.M), name
        for directive in ("log", "benchmark", "message"):
            assert f"    {directive}:\n" in body, (name, directive)
        assert "threads:" not in body, f"{name}: one thread, so that --cores changes no byte"


def test_memory_and_time_grow_with_a_recording(root) -> None:
    """With its frames, and time with its markers, too; and at each attempt."""
    text = (root / "workflow/rules/common.smk").read_text(encoding="utf-8")
    code = text[text.index("def memory(") : text.index("def settings(")]
    rows = {
        "short": SimpleNamespace(name="short", twin=None, markers=["A", "B"]),
        "long": SimpleNamespace(name="long", twin=None, markers=["A", "B"]),
        "many": SimpleNamespace(name="many", twin=None, markers=list("ABCDEFGHIJ")),
        "made": SimpleNamespace(name="made", twin="T", markers=[]),
    }
    frames = {"short": 1200, "long": 38_880_000, "many": 38_880_000}
    given = {
        "ceil": math.ceil,
        "RECORDINGS": SimpleNamespace(rows=rows),
        "TWINS": {"T": SimpleNamespace(duration_s=324_000.0, frame_rate_hz=120.0)},
        "selection": SimpleNamespace(most_frames=lambda row: frames[row.name]),
        "config": {},
    }
    exec(code, given)
    need = {
        name: [
            of(SimpleNamespace(recording=name), attempt)
            for of in (given["memory"](1000, arrays=10), given["minutes"](30, seconds=2))
            for attempt in (1, 2)
        ]
        for name in rows
    }
    assert need["short"] == [1000, 2000, 31, 62]
    assert need["long"] == [4110, 8220, 56, 112]
    assert need["many"] == [4110, 8220, 160, 320]
    assert need["made"] == need["long"]
    assert given["minutes"](10)(SimpleNamespace(), 2) == 20
