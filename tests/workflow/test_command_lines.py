"""Programs beside the workflow: their help, and one line for a report that cannot be written."""

import runpy
import sys

import pytest

PROGRAMS = (
    *("workflow/rule_graph.py", "workflow/write_report.py"),
    *("benchmarks/failing_camera.py", "benchmarks/noise_monte_carlo.py"),
    *("benchmarks/lighthouse_times.py", "benchmarks/noise_times.py", "benchmarks/peers.py"),
)


@pytest.mark.parametrize("program", PROGRAMS)
def test_help(program: str, root, monkeypatch, capsys) -> None:
    monkeypatch.setattr(sys, "argv", [program, "--help"])
    monkeypatch.setattr(sys, "path", [str((root / program).parent), *sys.path])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(root / program), run_name="__main__")
    said = capsys.readouterr()
    assert (ended.value.code, said.err) == (0, "")
    assert said.out.startswith(f"usage: {program.partition('/')[2]}")


@pytest.mark.parametrize(
    ("output", "line"),
    [
        ("", "the run did not finish"),
        ("Building\nDAG of\njobs\nsheet.tsv: no column group", "sheet.tsv: no column group"),
        ("FileNotFoundError in file x:\n[Errno 2]: 'out/report.html'", "the run did not finish"),
        ("WorkflowError:\nall is lost", "WorkflowError: all is lost"),
    ],
)
def test_why_there_is_no_report_is_never_empty(output: str, line: str, root, monkeypatch) -> None:
    monkeypatch.syspath_prepend(str(root / "workflow"))
    from write_report import why

    assert why(output).startswith(line)
