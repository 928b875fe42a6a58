"""`mocap-metrology monitor`: the sheet of a folder grows by a take, or nothing changes."""

import errno
import json
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mocap_metrology.cli import main as command
from mocap_metrology.cli import monitor
from mocap_metrology.common.paths import locked
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.recording import analyse
from mocap_metrology.recording.clean import clean

PLACES = np.array([[1000.0, 200, 900], [1500, 220, 910]])

Run = Callable[..., int]


def write_take(
    path: Path, seed: int, shift: float = 0, move: float = 0, labels: Sequence[str] = "AB",
    seen: float = 1, decimals: int = 9, first: int = 0,
) -> Path:  # fmt: skip
    """Two markers for 45 s: white noise of 0.03 mm, 0.07 mm from day to day; B is seen in the
    first share of the frames; those from `first` on."""
    rng, n = np.random.default_rng(seed), 2250
    x = PLACES + rng.normal(0, 0.07, (2, 3)) + rng.normal(0, 0.03, (n, 2, 3))
    x[:, :, 0] += shift + np.linspace(0, move, n)[:, None]
    x[round(seen * n) :, 1] = np.nan
    x = x[first:].round(decimals)
    write_c3d(path, list(labels), 50.0, iter([x.astype(np.float32)]), n - first)
    return path


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Adds a take to the folder `hall`; of its analysis only the first step, and no picture."""

    def first_step(
        entry: Any, name: str, folder: Path, settings: Any, tell: Any, progress: Any, *rest: Any
    ) -> None:
        clean(entry, analyse.origin(name, rest[1]), settings, folder, tell=tell)

    monkeypatch.setattr(monitor.analyse, "analyse", first_step)
    monkeypatch.setattr(
        "mocap_metrology.recording.monitor.monitors.chart", lambda rows, texts: texts
    )
    monkeypatch.setattr(
        "mocap_metrology.recording.monitor.save_png",
        lambda texts, path: path.write_text(texts.title),
    )

    def add(path: Path, *options: str) -> int:
        return command.main(["monitor", str(tmp_path / "hall"), str(path), *options])

    return add


def state(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "hall/results/monitors/hall/monitor.json").read_text())


def everything(folder: Path) -> dict[str, bytes]:
    return {str(p): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def grown(tmp_path: Path, run: Run, n: int) -> None:
    for k in range(1, n + 1):
        path = write_take(tmp_path / f"t{k}.c3d", k)
        assert run(path, "--date", f"2026-03-{k:02d}") == 0


def test_words_and_exit_status(
    tmp_path: Path, run: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    grown(tmp_path, run, 6)
    assert state(tmp_path)["word"] == "provisional"
    assert state(tmp_path)["valid"] is True
    for k, status in ((7, 3), (8, 4)):
        path = write_take(tmp_path / f"t{k}.c3d", k, shift=1)
        assert run(path, "--date", f"2026-03-{k:02d}") == status
    found = state(tmp_path)
    assert (found["word"], found["valid"], found["since"]) == ("failure", False, "2026-03-07")
    assert "place x" in found["not_valid"]
    assert "Monitor hall: failure (t8, 2026-03-08)" in capsys.readouterr().out
    rows = (tmp_path / "hall/recordings.tsv").read_text().splitlines()
    assert rows[0].split("\t") == ["recording", "path", "markers", "group", "date", "monitor"]
    assert len(rows) == 9
    assert run(write_take(tmp_path / "t9.c3d", 9, 1), "--date", "2026-03-09", "--restart") == 0
    assert state(tmp_path)["word"] == "learning"
    assert state(tmp_path)["restarted"] == "2026-03-09"


def test_all_markers_at_rest_are_watched(tmp_path: Path, run: Run) -> None:
    """The third one of four, the fourth moves; the next take keeps them."""
    rng = np.random.default_rng(1)
    for k in (1, 2):
        x = np.array([*PLACES, [0, 0, 500], [1, 1, 1]]) + rng.normal(0, 0.03, (2250, 4, 3))
        x[:, 3, 0] += np.linspace(0, 300, 2250)
        write_c3d(tmp_path / f"{k}.c3d", list("ABCD"), 50.0, iter([x.astype(np.float32)]), 2250)
        assert run(tmp_path / f"{k}.c3d", "--date", f"2026-03-0{k}") == 0
    assert state(tmp_path)["markers"] == ["A", "B", "C"]
    assert "Watched: A, B, C; length A-B." in state(tmp_path)["line"]


def test_a_label_that_no_sheet_can_hold_is_said(
    tmp_path: Path, run: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(write_take(tmp_path / "t.c3d", 1, labels=["A", "B;C"]), "--date", "2026-03-01") == 0
    assert state(tmp_path)["markers"] == ["A"]
    assert "not B;C: a label with a ; cannot be named, rename it" in capsys.readouterr().err


def test_what_is_refused_changes_nothing(
    tmp_path: Path, run: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    grown(tmp_path, run, 2)
    before = everything(tmp_path / "hall")
    copy = tmp_path / "copy.c3d"
    copy.write_bytes((tmp_path / "t1.c3d").read_bytes())
    coarse = write_take(tmp_path / "coarse.c3d", 1, decimals=1)
    part = write_take(tmp_path / "part.c3d", 1, first=500)
    other = write_take(tmp_path / "other.c3d", 5, labels="CD")
    moving = write_take(tmp_path / "moving.c3d", 6, move=50)
    exchanged = write_take(tmp_path / "exchanged.c3d", 7, labels="BA")
    hidden = write_take(tmp_path / "hidden.c3d", 8, seen=0.4)
    late = ("--date", "2026-03-05")
    no_cell = "no cell of a sheet can hold its name; rename it"
    for path, options, words in (
        (tmp_path / "t1.c3d", late, "is the file of row 2"),
        (copy, late, "it is the same file as t1"),
        (coarse, late, "it is t1 exported once more, with the same noise"),
        (part, late, "it is t1 exported once more, with the same noise"),
        (write_take(tmp_path / "old.c3d", 4), ("--date", "2026-02-05"), "2026-03-02 or later"),
        (copy, ("--date", "5 March"), 'column date: "5 March"; expected the date'),
        (other, late, "no marker 'A'"),
        (other, (*late, "--markers", "C", "D"), 'column markers: "C;D"; expected "A;B"'),
        (other, (*late, "--monitor", "../x"), 'column monitor: "../x"; expected letters'),
        (moving, late, "moving.c3d: its markers move"),
        (hidden, late, "B is seen in 40 % of the frames"),
        (exchanged, ("--date", "2999-03-05"), "its date is 2999-03-05, in the future"),
        (exchanged, late, "A, B stand where B, A stood in the take before"),
        (tmp_path / "none.c3d", late, "no such file"),
        (tmp_path, late, "is not a file"),
        (write_take(tmp_path / "a;b.c3d", 9), late, no_cell),
        (write_take(tmp_path / "a\nb.c3d", 10), late, no_cell),
    ):
        assert run(path, *options) == 1
        said = [line for line in capsys.readouterr().err.splitlines() if words in line]
        assert len(said) == 1, words
        assert everything(tmp_path / "hall") == before


def test_a_full_disk_keeps_what_there_is(
    tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    grown(tmp_path, run, 2)
    before, path = everything(tmp_path / "hall"), write_take(tmp_path / "t3.c3d", 3)

    def full(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    for target in ("monitor", "write_take", "Sheet.with_row"):
        with monkeypatch.context() as here:
            owner, _, name = f"mocap_metrology.cli.monitor.{target}".rpartition(".")
            here.setattr(f"{owner}.{name}", full)
            assert run(path, "--date", "2026-03-03") == 1
        assert "No space left on device; the take was not added" in capsys.readouterr().err
        assert everything(tmp_path / "hall") == before
    assert run(path, "--date", "2026-03-03") == 0


def test_two_commands_at_once_wait_for_each_other(tmp_path: Path, run: Run) -> None:
    """Both read the sheet before they write it, so that the row of one would be lost."""
    grown(tmp_path, run, 1)
    with ThreadPoolExecutor(2) as pool:
        with locked(tmp_path / "hall"):
            path = write_take(tmp_path / "t2.c3d", 2)
            waits = pool.submit(run, path, "--date", "2026-03-02")
            with pytest.raises(TimeoutError):
                waits.result(timeout=1)
        assert waits.result() == 0
    assert state(tmp_path)["takes"] == 2


def test_a_sheet_that_was_edited(tmp_path: Path, run: Run) -> None:
    """A comment, Windows line ends, a row removed, a column added, other capitals, Ctrl-Z."""
    grown(tmp_path, run, 3)
    sheet = tmp_path / "hall/recordings.tsv"
    head, first, _, third = [row.split("\t") for row in sheet.read_text().splitlines()]
    rows = [["comment", *head], ["as set up", *first], ["", *third]]
    text = "# our hall\r\n" + "".join("\t".join(row) + "\r\n" for row in rows)
    sheet.write_bytes(text.replace("recording\t", "Recording\t", 1).encode() + b"\x1a")
    assert run(write_take(tmp_path / "t4.c3d", 4), "--date", "2026-03-04") == 0
    assert sheet.read_bytes().startswith(text.encode())
    assert sheet.read_bytes().count(b"\r\n") == 5
    assert state(tmp_path)["takes"] == 3


@pytest.mark.parametrize(
    ("column", "cell", "said"),
    [
        (
            "frame_rate_hz",
            "fifty",
            'row 3, column frame_rate_hz: "fifty"; expected frames a second',
        ),
        ("unit", "cm", "t2.c3d: unit is 'cm', expected mm or m"),
    ],
)
def test_cells_of_a_sheet_that_was_edited_wrongly(
    tmp_path: Path, run: Run, capsys: pytest.CaptureFixture[str], column: str, cell: str, said: str
) -> None:
    grown(tmp_path, run, 1)
    sheet = tmp_path / "hall/recordings.tsv"
    head, row = sheet.read_text().splitlines()
    sheet.write_text(f"{head}\t{column}\n{row}\t{cell}\n")
    assert run(write_take(tmp_path / "t2.c3d", 2), "--date", "2026-03-02") == 1
    assert said in capsys.readouterr().err.splitlines()[-1]


def test_a_take_without_its_results_is_read_again(tmp_path: Path, run: Run) -> None:
    grown(tmp_path, run, 3)
    lost = tmp_path / "hall/results/recordings/t1/monitor_take.json"
    lost.unlink()
    (tmp_path / "t2.c3d").unlink()
    (tmp_path / "hall/results/recordings/t2/monitor_take.json").unlink()
    assert run(write_take(tmp_path / "t4.c3d", 4), "--date", "2026-03-04") == 0
    assert lost.exists()
    assert state(tmp_path)["takes"] == 3
    assert [one["recording"] for one in state(tmp_path)["left_out"]] == ["t2"]


def test_settings_of_the_folder(
    tmp_path: Path, run: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "hall"
    folder.mkdir()
    path = write_take(tmp_path / "t1.c3d", 1)
    for text, said in (
        (b"monitor: {tolerance: {place_m: 1}}\n", "config, key monitor.tolerance.place_m: unknown"),
        (b"\xff\xfe", "no readable YAML: 'utf-8' codec can't decode"),
    ):
        (folder / "config.yaml").write_bytes(text)
        assert run(path, "--date", "2026-03-01") == 1
        assert f"hall/config.yaml: {said}" in capsys.readouterr().err
    (folder / "config.yaml").write_text("monitor: {tolerance: {place_mm: 5}}\n")
    grown(tmp_path, run, 5)
    assert run(write_take(tmp_path / "t7.c3d", 7, shift=2), "--date", "2026-03-07") == 0
