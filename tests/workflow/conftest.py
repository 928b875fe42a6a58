"""What the tests of the workflow share: its library, and a toy project run by Snakemake itself."""

import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import forked
import laboratory
import pytest
from browser import NAMES
from running import command, environment

ROOT = Path(__file__).resolve().parents[2]
TWINS = "twins: {T: {published: {camera_type: T40, n_cameras: 10}, seed: 1}}\n"
TOY = Path(__file__).with_name("toy")
sys.path.insert(0, str(ROOT / "workflow"))

# Figures of the laboratory that tests read; a dot stands for the others
READ = "/verdict|calibrations/measured/"

Snakemake = Callable[..., subprocess.CompletedProcess]


@pytest.fixture(scope="session")
def executable() -> str:
    """A browser."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.skip("no Chromium or Chrome in PATH")
    return found


@pytest.fixture(scope="session")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Address of a process that has loaded Snakemake."""
    with forked.loaded(tmp_path_factory.mktemp("forked")) as address:
        yield address


@pytest.fixture(scope="session")
def snakemake(tmp_path_factory: pytest.TempPathFactory, loaded: str) -> Snakemake:
    """Run Snakemake in a folder, which draws the figures with `drawn` in their path, or all; both
    outputs come as `stdout`.

    The project itself runs from a folder of this session, as one folder takes one run at a time:
    other tests, and the user's own `make`, may be running it at the same time.
    """
    own = tmp_path_factory.mktemp("own")
    (own / "profiles").symlink_to(ROOT / "profiles")

    def run(folder: Path, *arguments: str, drawn: str = "") -> subprocess.CompletedProcess:
        if folder == ROOT:
            folder, arguments = own, ("-s", str(ROOT / "Snakefile"), *arguments)
        return forked.run(loaded, folder, command(*arguments)[3:], environment(drawn))

    return run


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory, snakemake: Snakemake) -> SimpleNamespace:
    """One run over everything in `laboratory`: its folder, `results`, `arguments`, `output`, and
    the figures that were `drawn`."""
    folder = tmp_path_factory.mktemp("laboratory")
    (folder / "profiles").symlink_to(ROOT / "profiles")
    settings = laboratory.write_everything(folder)
    for old in ("recordings/cut/allan.parquet", "calibrations/odd/pose.json"):
        (folder / "results" / old).parent.mkdir(parents=True)
        (folder / "results" / old).write_text("of an earlier input")
    quick = ["duration_s=60", "fit_figures=[]", "noise={estimators: [likelihood]}"]
    quick += ["lighthouse={estimators: [paper-lm], joint: setup}"]
    arguments = ["-s", str(ROOT / "Snakefile"), "--cores", "2", "--config", *settings, *quick]
    output = snakemake(folder, *arguments, drawn=READ)
    return SimpleNamespace(
        folder=folder, results=folder / "results", arguments=arguments, output=output, drawn=READ
    )


@pytest.fixture
def toy(tmp_path: Path) -> Path:
    """The project's own workflow folder with toy rules in place of the science.

    A recording is a text file: with `bad` in it it is refused, with `moves` warned of.
    """
    shutil.copy(ROOT / "Snakefile", tmp_path)
    for name in ("workflow", "profiles"):
        # Other tests may be writing byte code at the same time
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("src", "requirements"):
        (tmp_path / name).symlink_to(ROOT / name)
    shutil.copy(TOY / "Snakefile", tmp_path / "workflow/Snakefile")
    shutil.copy(TOY / "toy.smk", tmp_path / "workflow/rules/toy.smk")
    shutil.copy(TOY / "toy.py", tmp_path / "workflow/scripts/toy.py")
    (tmp_path / "config").mkdir()
    shutil.copy(ROOT / "config/config.yaml", tmp_path / "config/config.yaml")
    (tmp_path / "config/twins.yaml").write_text(TWINS)
    for sheet in (ROOT / "config").glob("calibrations*.tsv"):  # no rows, as there are no rules
        lines = sheet.read_text(encoding="utf-8").splitlines()
        header = next(line for line in lines if not line.startswith("#"))
        (tmp_path / "config" / sheet.name).write_text(f"{header}\n")
    rows = ["recording\tpath\tmarkers\tgroup"]
    for name, group in (("a", "g"), ("b", "g"), ("c", "h")):
        (tmp_path / f"config/{name}.c3d").write_text(f"{name} is good\n")
        rows.append(f"{name}\t{name}.c3d\tA;B\t{group}")
    rows.append("t\tsimulate:T\t\tt")
    (tmp_path / "config/recordings.tsv").write_text("\n".join(rows) + "\n")
    return tmp_path


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with files that a sheet can name."""
    monkeypatch.chdir(tmp_path)
    for name in ("a.c3d", "b.c3d", "board.csv", "poses.json", "ref.c3d", "dump.bin"):
        (tmp_path / name).write_text("x")
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub/a.c3d").write_text("x")
    return tmp_path
