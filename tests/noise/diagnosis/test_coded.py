"""Findings by code: documented, complete, and not in conflict with the sentences."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest

from mocap_metrology.common.files import write_json
from mocap_metrology.noise.findings import CODES, Finding

DOCUMENT = Path(__file__).parents[3] / "docs" / "findings.md"


def test_every_code_is_documented_with_its_unit() -> None:
    rows = re.findall(r"^\| `(\w+)` \| ([^|]*) ?\| ([^|]+) \|$", DOCUMENT.read_text("utf-8"), re.M)
    assert {code: (unit.strip(), words) for code, unit, words in rows} == CODES


def test_only_known_codes() -> None:
    with pytest.raises(ValueError, match="low_pass"):
        Finding("lowpass", "x1", 6.0)


def test_no_interval_is_null(tmp_path: Path) -> None:
    write_json(tmp_path / "f.json", {"findings": [Finding("event", "x1", 3.0).as_dict()]})
    (one,) = json.loads((tmp_path / "f.json").read_text())["findings"]
    assert one == {
        **{"code": "event", "series": "x1", "value": 3.0, "unit": "s"},
        **{"lower_95": None, "upper_95": None},
    }
    assert math.isnan(Finding("event", "x1", 3.0).lower_95)
