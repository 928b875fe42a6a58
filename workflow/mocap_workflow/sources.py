"""Hashes of what rules run: Snakemake sees no edit of a module, and of a script only its date.

They go by whole packages: an edit runs again everything that is computed with the package, be it
an edit of a comment.
"""

from __future__ import annotations

import hashlib
import importlib.util
from functools import cache
from importlib import metadata
from pathlib import Path

from mocap_metrology.common.faults import Faults
from mocap_workflow import VERSION

ALWAYS = ("step.py", "common", "reference")


class Sources:
    """Scripts of one folder, one installed package, one lock file."""

    def __init__(self, scripts: Path, package: Path, lock: Path):
        self.scripts, self.package, self.lock = scripts, package, lock

    def __call__(self, *names: str) -> str:
        """Hexadecimal hash of scripts (`noise.py`), of folders of the package (`noise`) with all
        below them, and of its files (`present/text/movement.py`); what every script needs and the
        lock file of a checkout are part of it."""
        total = hashlib.sha256(self.lock.read_bytes() if self.lock.is_file() else b"")
        for name in sorted({*ALWAYS, *names}):
            of = self.scripts if name.endswith(".py") and "/" not in name else self.package
            total.update(f"{name}\0{content(of / name)}\0".encode())
        return total.hexdigest()[:16]


@cache
def content(path: Path) -> str:
    """Hexadecimal hash of a file, or of the names and contents of all files in a folder."""
    if path.is_file():
        return hashlib.sha256(path.read_bytes()).hexdigest()
    if not path.is_dir():
        raise FileNotFoundError(path)
    total = hashlib.sha256()
    for file in sorted(path.rglob("*.*")):
        name = file.relative_to(path)
        if file.is_file() and not any(p.startswith(".") or p == "__pycache__" for p in name.parts):
            total.update(f"{name.as_posix()}\0{content(file)}\0".encode())
    return total.hexdigest()


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
    elif package != expected.resolve() and content(package) != content(expected):
        wrong = f"{name} is imported from {package}; expected {expected}"
        raise Faults([f"{wrong}: run `make env` here and use its .venv"])
    return package
