"""The folder of the results of one file: its name, and all of them or none."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import sys
import traceback
import uuid
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from mocap_metrology.common.errors import Refusal, one_line, printable
from mocap_metrology.common.paths import exists, is_abandoned, locked, real

CRASH = "crash.log"
PART = ".part-"
LONGEST = 60  # letters of a name, for titles
NONE, IN_PART = "no verdict", ", in part"  # words for what could not be said, in full or in part


def tell(words: str) -> None:
    """A line on what is being done, beside the verdict on standard output."""
    with suppress(BrokenPipeError):
        print(printable(words), file=sys.stderr, flush=True)


def tell_result(lines: Iterable[str]) -> None:
    """Lines of the verdict on standard output. Results are there all the same where nobody takes
    them, as of `| head -1`."""
    try:
        print("\n".join(map(printable, lines)), flush=True)
    except BrokenPipeError:
        sys.stdout = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115
    except OSError as error:
        tell(f"standard output: {error.strerror or error}")


def name_of(path: Path) -> str:
    """A name for a recording: `My file (2).c3d` is `My-file-2`. What is too long, or has no letter
    or digit of ASCII, is distinguished by a hash."""
    name = re.sub(r"[^A-Za-z0-9_.-]+", "-", path.stem).lstrip("_-.").rstrip("-.")
    digest = _digest(path.stem)
    if not re.search(r"[A-Za-z0-9]", name):
        return f"recording-{digest}"
    return name if len(name) <= LONGEST else f"{name[:12].rstrip('-._')}-{digest}"


def expect_text(*paths: Path) -> None:
    """Refuse names that are no text, which no result could hold."""
    for path in paths:
        try:
            str(path.absolute()).encode()
        except UnicodeEncodeError:
            raise Refusal(f"{path}: its name is not UTF-8; rename it") from None


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "surrogateescape")).hexdigest()[:6]


def folder_of(path: Path) -> Path:
    """Folder of results unless another one is requested: `take.c3d` beside `take.trc`."""
    return Path("results/check") / f"{name_of(path)}{path.suffix.lower()}"


def folders_of(paths: Sequence[Path]) -> list[tuple[Path, Path]]:
    """Files with their folders of results: `monday-take.c3d` where files of several folders have
    one name, and a hash where this is one name, too."""
    folders = [folder_of(path) for path in paths]
    for name in (lambda path: path.parent.name, lambda path: _digest(str(path))):
        longer = [path.with_name(f"{name(real(path))}-{path.name}") for path in paths]
        folders = [
            folder_of(path) if folders.count(folder) > 1 else folder
            for path, folder in zip(longer, folders, strict=True)
        ]
    return list(zip(paths, folders, strict=True))


@contextmanager
def replaced(folder: Path, names: Iterable[str]) -> Iterator[Path]:
    """A new folder to write to; on success its files replace those called `names` in `folder`,
    on failure it is removed and the folder remains unchanged. Those of killed commands go."""
    part = folder / f"{PART}{uuid.uuid4().hex[:12]}"
    created = next((p for p in (*reversed(folder.parents), folder) if not exists(p)), part)
    with ExitStack() as held:
        try:
            with locked(folder):
                for other in filter(is_abandoned, folder.glob(f"{PART}{'[0-9a-f]' * 12}")):
                    shutil.rmtree(other, ignore_errors=True)
                part.mkdir(parents=True)
                held.enter_context(locked(part))
        except OSError as error:
            why = error.strerror or error
            raise Refusal(f"{folder}: {why}; expected a folder to write to") from None
        try:
            yield part
            for name in (*names, CRASH):
                (folder / name).unlink(missing_ok=True)
            for path in part.iterdir():
                path.replace(folder / path.name)
            created = part
        finally:
            # After Ctrl-C a thread may still write into it
            shutil.rmtree(created, ignore_errors=True)


def write_crash(error: BaseException, folder: Path, name: str) -> str:
    """A crash in one line; its traceback is written to `crash.log` in the folder."""
    what = f"check of {name} crashed: {one_line(f'{type(error).__name__}: {error}')}"
    log = "".join(traceback.format_exception(error))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / CRASH).write_text(log, encoding="utf-8")
    except OSError:
        return f"{what}\n{log}"
    return f"{what}\n  traceback: {folder / CRASH}"
