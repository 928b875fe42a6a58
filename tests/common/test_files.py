"""Files are whole or absent; a damaged file of results is refused, and never read as another."""

import json
import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common.errors import Damaged
from mocap_metrology.common.files import (
    empty_folder,
    open_table,
    read_metadata,
    read_table,
    verify,
    whole,
    whole_folder,
    write_csv,
    write_folder,
    write_json,
    write_table,
)


def write(path: Path) -> None:
    """A file as steps write them, of what its name asks for."""
    draw = np.random.default_rng(1)
    columns = {
        "frame": np.arange(3000, dtype=np.int32),
        "x1_mm": draw.normal(size=3000).astype(np.float32),
        "L_mm": draw.normal(size=3000),
        "series": ["x1", "L"] * 1500,
        "outlier": draw.random(3000) < 0.5,
    }
    rows = [{"series": f"x{k}", "value": float(draw.normal())} for k in range(50)]
    if path.suffix == ".parquet":
        write_table(path, columns, {"frame_rate_hz": 120.0}, dictionary=["x1_mm"])
    elif path.suffix == ".csv":
        write_csv(path, rows)
    else:
        write_json(path, rows)


@pytest.mark.parametrize("name", ["noise.csv", "pose.json", "clean.parquet"])
def test_a_sound_file_in_the_place_of_another_is_found(tmp_path: Path, name: str) -> None:
    """Of another recording, or another of the same one; a folder of results may be moved."""
    path = tmp_path / "results/recordings/a" / name
    write(path)
    if not os.listxattr(path):
        pytest.skip("this file system keeps no extended attributes")
    moved = (tmp_path / "results").rename(tmp_path / "moved") / "recordings/a" / name
    verify(moved)
    for other in (moved.parents[1] / "b" / name, moved.with_name(f"other{moved.suffix}")):
        other.parent.mkdir(exist_ok=True)
        shutil.copy2(moved, other)
        with pytest.raises(Damaged, match=f"it was written as a/{name}"):
            verify(other)


def test_a_table_without_attributes_is_known_by_its_origin(tmp_path: Path) -> None:
    path, other = (tmp_path / f"recordings/{name}/clean.parquet" for name in "ab")
    write_table(path, {"frame": np.arange(3)}, {"recording": "a"})
    other.parent.mkdir()
    other.write_bytes(path.read_bytes())
    for read in (read_table, read_metadata, open_table):
        read(path)
        with pytest.raises(Damaged, match="it is of a;"):
            read(other)
    elsewhere = tmp_path / "mine.parquet"
    elsewhere.write_bytes(path.read_bytes())
    assert read_metadata(elsewhere) == {"recording": "a"}


@pytest.mark.parametrize(
    ("name", "text", "why"),
    [
        ("a.csv", "a,b\n1,2\n3,4\n", None),
        ("a.csv", "a,b\n1,2\n3\n", "equal length"),
        ("a.csv", "a,b\n1,2,3\n4,5,6\n", "equal length"),
        ("a.csv", "a,b\n1,2", "end is missing"),
        ("a.csv", "a,b\n\0,2\n", "zeros"),
        ("a.json", "{\n", "Expecting"),
        ("a.json", '"a":"1",\n"lighthouse0":{\n"id":"3"\n}\n', None),  # of libsurvive: no braces
        ("a.json", '"a":"1",\n"lighthouse0":{\n"id":"3"\n', "Expecting"),
    ],
)
def test_a_table_without_a_checksum_is_examined(tmp_path: Path, name, text, why) -> None:
    path = tmp_path / name
    path.write_text(text)
    if why is None:
        verify(path)
    else:
        with pytest.raises(Damaged, match=why):
            verify(path)


def test_metadata_are_protected(tmp_path: Path) -> None:
    """Pages have checksums of Parquet's own; a frame rate stands in the footer."""
    path = tmp_path / "clean.parquet"
    write(path)
    content = path.read_bytes()
    path.write_bytes(content.replace(b'"frame_rate_hz": 120.0', b'"frame_rate_hz": 121.0'))
    for read in (read_metadata, read_table):
        with pytest.raises(Damaged, match=r"clean\.parquet is damaged: its footer"):
            read(path)


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
