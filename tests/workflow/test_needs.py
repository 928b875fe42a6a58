"""Memory and time that a job asks for."""

import os
from pathlib import Path
from types import SimpleNamespace

from mocap_workflow.needs import Needs


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
