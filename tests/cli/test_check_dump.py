"""`mocap-metrology check` of a sweep dump: the verdict does not wait for the figures."""

from __future__ import annotations

from pathlib import Path

import yaml
from mocap_workflow.calibration_twins import calibration_twin

from mocap_metrology.calibration.sweeps import write_board
from mocap_metrology.cli import calibration, main
from mocap_metrology.lighthouse.simulate.recording import simulate, write_dump


def test_verdict_before_the_figures(tmp_path: Path, root: Path, monkeypatch, capsys) -> None:
    """Where a figure fails after it, no results are left and the status says so."""
    said = []

    def broken(*_: object) -> None:
        said.append(capsys.readouterr())
        raise IndexError("no axes")

    monkeypatch.setattr(calibration, "track_figure", broken)
    twin = calibration_twin(yaml.safe_load((root / "config/twins.yaml").read_text()), "sim-1-1")
    made = simulate(twin.model_copy(update={"duration_s": 1.0}), 7)
    write_dump(tmp_path / "dump.bin", made.pulses)
    write_board(str(tmp_path / "board.csv"), made.truth.board)
    files = [str(tmp_path / name) for name in ("dump.bin", "board.csv", "one")]
    assert main.main(["check", files[0], "--board", files[1], "--output", files[2]]) == 1
    verdict, *_, last = said[0].out.splitlines()
    assert verdict.startswith("dump: ")
    assert last.split()[:6] == ["1", "σ", "about", "x,", "y,", "z"]
    assert said[0].err.splitlines()[-1] == "3/3 figures"
    assert capsys.readouterr().err.splitlines()[-1] == "No results were written"
    assert [path.name for path in (tmp_path / "one").iterdir()] == ["crash.log"]
