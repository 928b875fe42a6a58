"""A refused recording spoils no table and is named last; mended, only its own branch runs."""

from pathlib import Path

from running import finished


def test_refusal_rerun_mending_and_a_new_row(toy: Path, snakemake) -> None:
    (toy / "config/b.c3d").write_text("b is bad\n")
    (toy / "config/c.c3d").write_text("c moves\n")
    old = toy / "results/recordings/b/noise.csv"
    old.parent.mkdir(parents=True)
    old.write_text("from an earlier run\n")

    first = snakemake(toy, "--cores", "2", "--retries", "1")  # of failures, not of refusals
    assert first.returncode == 1, first.stdout
    lines = first.stdout.splitlines()
    assert lines.count("recording b refused: it is bad") == 1
    assert lines.count("warning: recording c: marker A moves") == 1
    assert finished(first.stdout) == {"clean": 3, "clean_twin": 1, "noise": 3, "group_table": 3}
    tables = toy / "results/tables"
    assert (tables / "g_noise.csv").read_text() == "a is good\n"
    assert (tables / "h_noise.csv").read_text() == "c moves\n"
    assert (tables / "t_noise.csv").read_text() == "T\n"
    assert not old.exists()

    (toy / "config/b.c3d").write_text("b is mended\n")
    with (toy / "config/recordings.tsv").open("a") as stream:
        stream.write("u\tsimulate:T\t\tt\n")
    mended = snakemake(toy, "--cores", "2")
    assert mended.returncode == 0, mended.stdout
    assert finished(mended.stdout) == {
        "clean": 1,  # b
        "clean_twin": 1,  # u
        "noise": 2,
        "group_table": 2,  # g and t, not h
        "gate": 1,
        "default": 1,
    }
    assert (tables / "g_noise.csv").read_text() == "a is good\nb is mended\n"
    assert (tables / "t_noise.csv").read_text() == "T\nT\n"
