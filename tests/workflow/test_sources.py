"""An edit runs again what is computed with the package that it is in, and nothing else."""

from __future__ import annotations

import ast
import functools
import importlib
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from mocap_workflow import sources
from mocap_workflow.sources import ALWAYS, Sources, installed
from running import command, environment, pass_for_computed, planned, write_sheet

from mocap_metrology.common.faults import Faults

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS, PACKAGE = ROOT / "workflow/scripts", ROOT / "src/mocap_metrology"
LEFT_ALONE = {  # by an edit of each package, of the rules for a recording and a calibration
    "io": {"skurowski_theory"},
    "noise": set(),
    "lighthouse": {
        *("clean_twin", "noise", "verdict", "skurowski_theory", "group_tables"),
    },
    "present": {"clean_twin", "noise", "calibration_twins_1"},
}
RULE = re.compile(r"^ *(?:rule|checkpoint)(?: (\w+))?:\n(.*?)(?=^\S|\Z)", re.M | re.S)
SOURCE = re.compile(r"\bcode=source\((.*?)\)", re.S)
SCRIPT = re.compile(r'script:\s+"\.\./scripts/(\w+\.py)"')


def named() -> dict[str, set[str]]:
    """Scripts and packages of every rule that runs a script, by rule."""
    found = {}
    for path in sorted((ROOT / "workflow/rules").glob("*.smk")):
        for rule, text in RULE.findall(path.read_text(encoding="utf-8")):
            if script := SCRIPT.search(text):
                names = re.findall(r'"([^"]+)"', SOURCE.search(text)[1])
                assert names[0] == script[1], rule
                found[rule or script[1]] = set(names)
    return found


NAMED = named()


@functools.cache
def imports(path: Path) -> list[Path]:
    """Files of the package and beside the script that a file imports, in functions too."""
    found = []
    base = (
        [PACKAGE.name, *path.parent.relative_to(PACKAGE).parts] if PACKAGE in path.parents else []
    )
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            start = base[: len(base) - node.level + 1] if node.level else []
            module = ".".join([*start, *([node.module] if node.module else [])])
            names = [module, *(f"{module}.{alias.name}" for alias in node.names)]
        else:
            continue
        for name in names:
            for folder in (SCRIPTS, PACKAGE.parent):
                file = folder.joinpath(*name.split("."))
                found += [file.with_suffix(".py"), file / "__init__.py"]
    lazy = PACKAGE / "__init__.py"  # whose names are imported where they are used
    return [file for file in found if file.is_file() and file != lazy]


def reached(script: Path) -> set[str]:
    """Scripts and packages that a script imports, directly or through others."""
    seen, waiting = set(), [script]
    while waiting:
        path = waiting.pop()
        if path not in seen:
            seen.add(path)
            waiting += imports(path)
    beside = {path.name for path in seen if path.parent == SCRIPTS}
    parts = {path.relative_to(PACKAGE).parts for path in seen if PACKAGE in path.parents}
    folders = {first for first, *rest in parts if rest}
    shown = {"/".join(rest) for first, *rest in parts if first == "present" and rest}
    words = {name for name in shown if name.startswith("text/") and "__" not in name}
    if words == shown - {"__init__.py", "text/__init__.py"}:  # of a result, and no figures
        folders = folders - {"present"} | {f"present/{name}" for name in words}
    return beside | folders


@pytest.mark.parametrize("rule", NAMED)
def test_a_rule_names_what_its_script_imports(rule: str) -> None:
    scripts = [name for name in NAMED[rule] if name.endswith(".py") and "/" not in name]
    found = set().union(*(reached(SCRIPTS / name) for name in scripts))
    assert NAMED[rule] == found - set(ALWAYS)


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    """A copy of the project with a recording and a calibration that pass for computed."""
    ignored = shutil.ignore_patterns("__pycache__", ".*")
    for name in ("workflow", "src", "config", "profiles", "requirements"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=ignored)
    shutil.copy(ROOT / "Snakefile", tmp_path)
    return tmp_path


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess:
    """Snakemake of a copy, with its package."""
    return subprocess.run(
        command(*arguments),
        cwd=folder,
        env=environment() | {"PYTHONPATH": str(folder / "src")},
        capture_output=True,
        text=True,
        timeout=900,
    )


def test_an_edit_of_a_package_runs_again_what_is_computed_with_it(copied: Path) -> None:
    twin = {"recording": "one", "path": "simulate:walk-and-white", "group": "lab"}
    pair = {"calibration": "sim-1-1", "setup": "sim-1", "group": "jansen2019"}
    pair |= {"path": "simulate:sim-1-1", "format": "gpio-dump"}
    settings = []
    for name, row in (("recordings", twin), ("calibrations", pair)):
        (copied / write_sheet(copied, list(row), row)).rename(copied / f"{name}.tsv")
        settings.append(f"{name}={name}.tsv")
    arguments = ("--config", *settings, f"results={copied}/results")
    of = functools.partial(run, copied)
    pass_for_computed(of, *arguments)
    plans = {}
    for part in LEFT_ALONE:
        file = copied / f"src/mocap_metrology/{part}/__init__.py"
        before = file.read_text(encoding="utf-8")
        file.write_text(f"{before}# a word\n", encoding="utf-8")
        plans[part] = set(planned(of("-n", *arguments).stdout))
        file.write_text(before, encoding="utf-8")
    everything = set().union(*plans.values())
    assert {part: everything - plan for part, plan in plans.items()} == LEFT_ALONE


def test_words_alone_measure_no_recording_again(copied: Path) -> None:
    """An edit of words that no step of a recording stores."""
    (copied / "given.c3d").touch()
    given = {"recording": "real", "path": "given.c3d", "markers": "A;B", "group": "lab"}
    write_sheet(copied, list(given), given)
    settings = ("--config", "recordings=sheet.tsv", "calibrations=", f"results={copied}/results")
    target = f"{copied}/results/recordings/real/check.json"
    of = functools.partial(run, copied)
    pass_for_computed(of, target, *settings)
    (copied / "src/mocap_metrology/present/text/captions.py").write_text("# a word\n")
    done = of("-n", target, *settings)
    assert planned(done.stdout) == {}, done.stdout + done.stderr


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A script of its own, one helper, two packages, a lock file."""
    names = ["common/errors.py", "reference/table.csv", "noise/fit/search.py", "present/page.html"]
    names = [f"package/{name}" for name in names] + ["package/noise/__pycache__/search.pyc"]
    for name in (*names, "scripts/step.py", "scripts/allan.py", "scripts/psd.py", "lock.txt"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name)
    return tmp_path


def hashes(root: Path) -> list[str]:
    """Of a script of numbers and of one that draws too."""
    sources.content.cache_clear()
    source = Sources(root / "scripts", root / "package", root / "lock.txt")
    return [source("allan.py", "noise"), source("psd.py", "noise", "present")]


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("scripts/allan.py", [True, False]),
        ("scripts/step.py", [True, True]),
        ("package/common/errors.py", [True, True]),
        ("package/reference/table.csv", [True, True]),
        ("package/noise/fit/search.py", [True, True]),
        ("package/noise/fit/new.py", [True, True]),
        ("package/noise/__pycache__/search.pyc", [False, False]),
        ("package/present/page.html", [False, True]),
        ("lock.txt", [True, True]),
    ],
)
def test_what_an_edit_changes(small: Path, name: str, changed: list[bool]) -> None:
    before = hashes(small)
    (small / name).write_text("edited")
    assert [old != new for old, new in zip(before, hashes(small), strict=True)] == changed


def test_a_copy_elsewhere_has_the_same_hashes(small: Path, tmp_path_factory) -> None:
    copy = tmp_path_factory.mktemp("copy") / "clone"
    shutil.copytree(small, copy)
    assert hashes(copy) == hashes(small)


def test_what_is_not_there_is_no_source(small: Path) -> None:
    with pytest.raises(FileNotFoundError, match="gone"):
        Sources(small / "scripts", small / "package", small / "lock.txt")("allan.py", "gone")


def test_the_package_is_that_of_the_workflow(tmp_path: Path, monkeypatch) -> None:
    assert installed("mocap_metrology", ROOT) == PACKAGE.resolve()
    with pytest.raises(Faults, match="not_there is not installed in this Python"):
        installed("not_there", ROOT)
    assert installed("mocap_metrology", tmp_path) == PACKAGE.resolve()
    monkeypatch.setattr(sources, "VERSION", "9.9")
    with pytest.raises(Faults, match=r"mocap_metrology 0\.1\.0 is installed; expected 9\.9"):
        installed("mocap_metrology", tmp_path)


def test_the_environment_of_another_checkout_serves_as_long_as_nothing_differs(
    tmp_path: Path,
) -> None:
    copy = tmp_path / "src/mocap_metrology"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__", ".*"))
    assert installed("mocap_metrology", tmp_path) == PACKAGE.resolve()
    (copy / "noise/columns.py").write_text("# a word\n")
    sources.content.cache_clear()
    with pytest.raises(Faults, match=r"mocap_metrology is imported from .*; expected .*make env"):
        installed("mocap_metrology", tmp_path)


def test_the_workflow_and_its_package_have_one_version() -> None:
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert f'version = "{sources.VERSION}"' in text


@pytest.mark.parametrize("script", sorted(SCRIPTS.glob("*.py")), ids=lambda path: path.stem)
def test_what_a_script_imports_is_there(script: Path) -> None:
    """A module that was moved away would be named by no rule, and fail in the job."""
    for node in ast.walk(ast.parse(script.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("mocap_metrology"):
            for alias in node.names:
                if not hasattr(importlib.import_module(node.module), alias.name):
                    importlib.import_module(f"{node.module}.{alias.name}")
