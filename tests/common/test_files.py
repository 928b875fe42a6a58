"""Whole files, and tables that keep their numbers and their origin."""

import json

import numpy as np
import pytest

from mocap_metrology.common.files import empty_folder, whole, whole_folder, write_folder, write_json


def test_whole_or_absent(tmp_path):
    path = tmp_path / "deep/er/result.txt"
    with whole(path) as part:
        part.write_text("one")
    with pytest.raises(RuntimeError), whole(path) as part:
        part.write_text("half")
        raise RuntimeError
    assert path.read_text() == "one"
    assert [p.name for p in path.parent.iterdir()] == ["result.txt"]


def test_json_has_no_nan(tmp_path):
    write_json(tmp_path / "x.json", {"a": np.float64("nan"), "b": (np.int64(1), np.bool_(True))})
    assert json.loads((tmp_path / "x.json").read_text()) == {"a": None, "b": [1, True]}


def test_an_emptied_folder_has_neither_files_nor_folders(tmp_path):
    """And what a link points to stays."""
    own, other = tmp_path / "own", tmp_path / "other"
    (own / "fit").mkdir(parents=True)
    (own / "fit/x1.png").write_text("old")
    (own / "check.json").write_text("old")
    other.mkdir()
    (other / "kept").write_text("kept")
    (own / "link").symlink_to(other)
    empty_folder(own)
    assert list(own.iterdir()) == []
    assert (other / "kept").read_text() == "kept"


def test_a_folder_is_replaced_as_a_whole_or_not_at_all(tmp_path) -> None:
    folder = tmp_path / "pages"
    write_folder(folder, {"a.html": "old", "b/c.html": "old"})
    with pytest.raises(RuntimeError), whole_folder(folder) as part:
        (part / "a.html").write_text("half")
        raise RuntimeError
    assert (folder / "a.html").read_text() == "old"
    write_folder(folder, {"a.html": "new"})
    assert [path.name for path in folder.iterdir()] == ["a.html"]
    assert (folder / "a.html").read_text() == "new"
    assert [path.name for path in tmp_path.iterdir()] == ["pages"]
