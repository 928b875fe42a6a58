"""What every rule says of itself."""

import os
import re
import textwrap
from pathlib import Path
from types import SimpleNamespace

from mocap_workflow.needs import Needs


def rules(root) -> dict[str, str]:
    """Text of each rule that runs a script, by name."""
    texts = [path.read_text(encoding="utf-8") for path in (root / "workflow/rules").glob("*.smk")]
    text = "\n".join(texts)
    found = re.findall(r"^(?:rule|checkpoint) (\w+):\n((?: .*\n|\n(?= ))+)", text, re.M)
    loops = r"^for NAME, OF in (\w+)\.items\(\):\n\n    rule:\n((?: .*\n|\n(?= ))+)"
    for table, body in re.findall(loops, text, re.M):
        entries = text.partition(f"\n{table} = {{\n")[2].partition("\n}\n")[0]
        names = re.findall(r'^    "(\w+)": \{$', entries, re.M)
        found += [(name, textwrap.indent(textwrap.dedent(body), "    ")) for name in names]
    return {name: body for name, body in found if "script:" in body}


def test_every_rule_says_what_it_needs_and_where_it_tells(root) -> None:
    found = rules(root)
    assert len(found) > 30
    for name, body in found.items():
        assert re.search(r"^ +mem_mb=memory\(\d+(, arrays=\d+)?\),$", body, re.M), name
        assert re.search(r"^ +runtime=minutes\(\d+(, seconds=[\d.]+)?\),$", body, re.M), name
        for directive in ("log", "benchmark", "message"):
            assert f"    {directive}:\n" in body, (name, directive)
        assert "threads:" not in body, f"{name}: one thread, so that --cores changes no byte"


def test_memory_and_time_grow_with_a_recording(tmp_path: Path) -> None:
    """With its frames, and time with its markers, too; and at each attempt."""
    frames = {"short": (1200, "AB"), "long": (38_880_000, "AB"), "many": (38_880_000, "ABCDEFGHIJ")}
    rows = {"made": SimpleNamespace(twin="T"), "distant": SimpleNamespace(twin=None, markers="A")}
    for name, (count, markers) in frames.items():
        paths = [tmp_path / f"{name}{part}" for part in range(2)]
        for path in paths:  # of frames of whole numbers, the smallest there are
            path.touch()
            os.truncate(path, count // 2 * len(markers) * 8)
        rows[name] = SimpleNamespace(twin=None, markers=markers, paths=[*map(str, paths)])
    rows["distant"].paths = ["s3://lab/a.c3d"]
    twin = SimpleNamespace(duration_s=324_000.0, frame_rate_hz=120.0)
    needs = Needs(rows, {"T": twin})
    need = {
        name: [
            of(SimpleNamespace(recording=name), attempt)
            for of in (needs.memory(1000, arrays=10), needs.minutes(30, seconds=2))
            for attempt in (1, 2)
        ]
        for name in rows
    }
    assert need["short"] == [1000, 2000, 31, 62]
    assert need["long"] == [4110, 8220, 56, 112]
    assert need["many"] == [4110, 8220, 160, 320]
    assert need["made"] == need["long"]
    assert need["distant"] == [1000, 2000, 30, 60]
    assert needs.minutes(10)(SimpleNamespace(), 2) == 20
