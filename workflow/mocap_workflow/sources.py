"""Hashes of what rules run: Snakemake sees no edit of a module, and of a script only its date.

An edit of a file, be it of a comment, runs again every script that imports it, directly or through
others.
"""

from __future__ import annotations

import hashlib
import importlib.util
import re
from collections.abc import Callable
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

from mocap_metrology.common.faults import Faults
from mocap_workflow import VERSION

IMPORT = re.compile(r"^\s*(?:from ([\w.]+) import (\([^)]*\)|.+)|import ([\w.]+))", re.MULTILINE)
READ_BY = {"pages": "html"}  # a folder without modules by that of its readers, both in `present`


class Sources:
    """Scripts of one folder, one installed package, one lock file."""

    def __init__(self, scripts: Path, package: Path, lock: Path):
        self.scripts, self.package, self.lock = scripts, package, lock

    def __call__(self, script: str) -> Callable[[Any], str]:
        """For `params`: hexadecimal hash of a script with all that it imports, of the data files
        beside these modules, of the published tables and of the lock file."""
        digest = cache(lambda: self.digest(script))
        return lambda wildcards: digest()

    def digest(self, script: str) -> str:
        """See `__call__`."""
        total = hashlib.sha256()
        every = {*self.reached(script), *data_in(self.package / "reference"), self.lock}
        for file in sorted(every, key=str):
            if file.is_file():
                total.update(f"{file.name}\0{content(file)}\0".encode())
        return total.hexdigest()[:16]

    def reached(self, script: str) -> set[Path]:
        """Files that a script imports, directly or through others, and data beside them."""
        seen: set[Path] = set()
        waiting = [self.scripts / script]
        while waiting:
            path = waiting.pop()
            if path not in seen:
                seen.add(path)
                waiting += imported(path, self.scripts, self.package) - seen
        folders = {path.parent for path in seen}
        folders = {folder for folder in folders if self.package in (folder, *folder.parents)}
        folders |= {one.with_name(READ_BY[one.name]) for one in folders if one.name in READ_BY}
        return seen.union(*map(data_in, folders))


@cache
def data_in(folder: Path) -> set[Path]:
    """Files in a folder that are no modules."""
    files = folder.glob("*.*")
    return {file for file in files if file.is_file() and not file.suffix.startswith(".py")}


@cache
def files_of(module: str, scripts: Path, package: Path) -> list[Path]:
    """Files that an import of this name executes, but for that of the package itself, which imports
    what its names stand for only where they are used."""
    first, *rest = module.split(".")
    if first != package.name:
        return [file for file in [scripts / f"{first}.py"] if file.is_file()]
    places = [package.joinpath(*rest[: count + 1]) for count in range(len(rest))]
    files = [file for one in places for file in (one.with_suffix(".py"), one / "__init__.py")]
    return [file for file in files if file.is_file()]


@cache
def imported(path: Path, scripts: Path, package: Path) -> set[Path]:
    """Files of all modules that a file may import, in functions too."""
    names: set[str] = set()
    for module, several, one in IMPORT.findall(path.read_text(encoding="utf-8")):
        names |= {one} if one else {f"{module}.{name}" for name in re.findall(r"\w+", several)}
    return {file for name in names for file in files_of(name, scripts, package)}


@cache
def content(path: Path) -> str:
    """Hexadecimal hash of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def installed(name: str, root: Path) -> Path:
    """Folder of the package that scripts will import, refused unless it is that of this workflow.

    In a checkout that is what lies in its `src`; an environment of another checkout would otherwise
    run that one's code without a word. Elsewhere it is what has the workflow's version.
    """
    spec = importlib.util.find_spec(name)
    expected = root / "src" / name
    if spec is None or spec.origin is None:
        raise Faults([f"{name} is not installed in this Python; expected the one of `make env`"])
    package = Path(spec.origin).resolve().parent
    if not expected.is_dir():
        version = metadata.version(name)
        if version != VERSION:
            raise Faults([f"{name} {version} is installed; expected {VERSION}, as the workflow is"])
    elif package != expected.resolve() and _modules(package) != _modules(expected):
        wrong = f"{name} is imported from {package}; expected {expected}"
        raise Faults([f"{wrong}: run `make env` here and use its .venv"])
    return package


def _modules(folder: Path) -> dict[str, str]:
    return {str(path.relative_to(folder)): content(path) for path in sorted(folder.rglob("*.py"))}
