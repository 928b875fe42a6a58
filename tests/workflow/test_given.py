"""Files that sheets name: hashed once, and again only if they change."""

import json
import os
from pathlib import Path

import pytest
from mocap_workflow import given
from mocap_workflow.given import contents


@pytest.fixture
def record(tmp_path: Path) -> Path:
    return tmp_path / "hidden/contents.json"


def hashed(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Paths that are read from now on."""
    read: list[str] = []

    def sha256(path: str) -> str:
        read.append(path)
        return Path(path).read_text()

    monkeypatch.setattr(given, "sha256", sha256)
    return read


def test_a_file_is_read_once_and_again_where_it_may_have_changed(
    tmp_path: Path, record: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = hashed(monkeypatch)
    path = tmp_path / "a.c3d"
    path.write_text("first")
    name = str(path)
    assert contents([name, name], record) == {name: "first"}
    assert contents([name], record) == {name: "first"}
    assert read == [name]
    path.touch()
    assert contents([name], record) == {name: "first"}
    assert read == [name] * 2


def test_a_file_with_an_older_date_and_the_same_size_is_noticed(
    tmp_path: Path, record: Path
) -> None:
    old, new = tmp_path / "old.c3d", tmp_path / "new.c3d"
    old.write_text("other")
    new.write_text("first")
    os.utime(old, ns=(0, 0))
    before = contents([str(new)], record)
    old.replace(new)
    assert contents([str(new)], record) != before


def test_a_missing_file_and_a_damaged_record(tmp_path: Path, record: Path) -> None:
    missing, there = str(tmp_path / "no.c3d"), str(tmp_path / "a.c3d")
    Path(there).write_text("first")
    expected = contents([missing, there], record)
    assert expected[missing] is None
    for damaged in ("", "[]", "{", json.dumps({there: 1}), json.dumps({there: []})):
        record.write_text(damaged)
        assert contents([missing, there, "x" * 5000], record) == expected | {"x" * 5000: None}
    Path(there).unlink()
    assert contents([there], record) == {there: None}
