"""`mocap-metrology check` of a sweep dump: the verdict does not wait for the figures."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from mocap_workflow.calibration_twins import calibration_twin

from mocap_metrology.calibration.sweeps import write_board
from mocap_metrology.cli import calibration, main
from mocap_metrology.lighthouse.simulate.recording import simulate, write_dump
from mocap_metrology.present.plot.figure import Texts, words_picture


def test_verdict_before_the_figures(tmp_path: Path, root: Path, monkeypatch, capsys) -> None:
    """Where a figure fails after it, no results are left and the status says so, also where the
    other process draws for longer."""
    printed = []
    started = multiprocessing.get_context("fork").Event()

    def broken(*_: object) -> None:
        printed.append(capsys.readouterr())
        assert started.wait(60)
        raise IndexError("no axes")

    def slow(*_: object) -> object:
        started.set()
        time.sleep(0.2)
        return words_picture("late", Texts(""))

    monkeypatch.setattr(calibration, "track_figure", broken)
    monkeypatch.setattr(calibration, "calibration_figure", slow)
    twin = calibration_twin(yaml.safe_load((root / "config/twins.yaml").read_text()), "sim-1-1")
    simulated = simulate(twin.model_copy(update={"duration_s": 1.0}), 7)
    write_dump(tmp_path / "dump.bin", simulated.pulses)
    write_board(str(tmp_path / "board.csv"), simulated.truth.board)
    files = [str(tmp_path / name) for name in ("dump.bin", "board.csv", "one")]
    with_table = ["check", files[0], "--board", files[1], "--output", files[2]]
    assert main.main([*with_table, "--reference", files[1]]) == 1
    said = "board.csv: cannot be read as JSON"
    assert capsys.readouterr().err.splitlines()[-1].startswith(said)
    assert not (tmp_path / "one").exists()
    assert main.main(["check", files[0], "--board", files[1], "--output", files[2]]) == 1
    verdict, *_, last = printed[0].out.splitlines()
    assert verdict.startswith("dump: ")
    assert last.split()[:6] == ["1", "σ", "about", "x,", "y,", "z"]
    assert printed[0].err.splitlines()[-1] == "3/3 figures"
    assert capsys.readouterr().err.splitlines()[-1] == "No results were written"
    assert [path.name for path in (tmp_path / "one").iterdir()] == ["crash.log"]
    # A bar that cannot be judged leaves the verdict, and is said by the status
    monkeypatch.setattr(calibration, "track_figure", slow)
    assert main.main([*with_table, "--bar", "A-B"]) == 1
    printed = [capsys.readouterr()]
    assert printed[0].out.splitlines()[0] == verdict
    assert printed[0].err.splitlines()[-1].startswith("--bar: ")
    assert "pose.json" in [path.name for path in (tmp_path / "one").iterdir()]


@pytest.mark.parametrize("option", ["world-points", "factory", "reference"])
def test_a_file_beside_the_dump_that_is_missing_is_named(option: str, tmp_path, capsys) -> None:
    (tmp_path / "dump.bin").touch()
    arguments = [str(tmp_path / "dump.bin"), "--board", "b.csv", f"--{option}", "none.json"]
    assert main.main(["check", *arguments, "--output", str(tmp_path / "out")]) == 1
    message = f"none.json: no such file; expected that of --{option}"
    assert capsys.readouterr().err.splitlines()[-1] == message


def test_another_process_draws_and_its_failures_are_raised_here() -> None:
    with calibration.drawing_process() as second:
        assert second.submit(os.getpid).result() != os.getpid()
        with pytest.raises(ZeroDivisionError):
            second.submit(divmod, 1, 0).result()
        with pytest.raises(BrokenProcessPool):
            second.submit(os._exit, 3).result()


def test_no_process_is_left_where_the_first_is_killed() -> None:
    code = "import os, time\nfrom mocap_metrology.cli.calibration import drawing_process\n"
    code += "second = drawing_process()\nprint(second.submit(os.getpid).result(), flush=True)\n"
    code += "time.sleep(60)\n"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as first:
        state = Path(f"/proc/{int(first.stdout.readline())}/stat")
        first.send_signal(signal.SIGKILL)
        first.wait()
    for _ in range(100):
        if not state.exists() or state.read_text().split()[2] == "Z":
            return
        time.sleep(0.05)
    pytest.fail(f"{state} is still there")


def test_what_the_chosen_estimate_left_out_is_told_once() -> None:
    """Not what the verdict states already, nor what another estimate left out."""
    kinds = [{"estimator": "batch", "optics": o, "note": "diode 7"} for o in ("factory", "ideal")]
    left = ["batch, factory: directions", "batch, ideal: directions", "no view of 3", "diode 7"]
    pose = {
        "poses": kinds,
        "diagnostics": {"left_out": left},
        "verdict": {"reason": "no view of 3"},
    }
    results = SimpleNamespace(entries={"slave": kinds[0], "4": None}, pose=pose)
    assert calibration._notes(results) == ["batch, factory: directions", "diode 7"]
