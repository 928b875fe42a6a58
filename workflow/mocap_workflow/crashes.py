"""What crashed, in one line with the place of its traceback, out of what Snakemake said."""

from __future__ import annotations

import re
import traceback
from pathlib import Path

FAILED = re.compile(r"^Error in rule (\w+):$", re.MULTILINE)
LOG = re.compile(r"^ +log: (.+?)(?: \(check log.*)?$", re.MULTILINE)
SAID = re.compile(r"^\d\d:\d\d:\d\d ERROR (.+)$", re.MULTILINE)
PLACE = re.compile(r'^ +File "(.+)", line (\d+), in (.+)$', re.MULTILINE)
DIED = re.compile(r"(died with <.+>|returned non-zero exit status -?\d+)\.?$", re.MULTILINE)
TRACEBACK = "Traceback (most recent call last)"


def crashes(said: str) -> list[str]:
    """One line or two a rule that failed, out of the text of Snakemake's run; [] where none did."""
    told: dict[str, None] = {}
    starts = [*FAILED.finditer(said)]
    for number, failed in enumerate(starts):
        end = starts[number + 1].start() if number + 1 < len(starts) else len(said)
        log = LOG.search(said, failed.end(), end)
        before = said[starts[number - 1].end() if number else 0 : failed.start()]
        told |= dict.fromkeys(_one(failed[1], Path(log[1]) if log else None, before))
    return list(told)


def _one(rule: str, log: Path | None, before: str) -> list[str]:
    try:
        text = log.read_text(encoding="utf-8", errors="replace").rstrip() if log else ""
    except OSError:
        text = ""
    said = SAID.findall(text)
    if said and TRACEBACK not in text:
        return [f"step {rule}: {said[-1]}"]  # a refusal
    if said or TRACEBACK in text:
        what = said[-1] if said else text.splitlines()[-1]
        what = what.removesuffix(f" (see {log})")
        place = PLACE.findall(text)
        where = f", in {Path(place[-1][0]).name}, line {place[-1][1]}" if place else ""
        return [f"step {rule} crashed: {what}{where}", f"  traceback: {log}"]
    died = DIED.findall(before)
    how = died[-1] if died else "without a word"
    last = f": {text.splitlines()[-1]}" if text else ""
    return [f"step {rule} ended: {how}{last}", *([f"  its log: {log}"] if log else [])]


def kept(error: BaseException, folder: Path, doing: str) -> str:
    """A crash outside any rule, in a line; its traceback goes to `crash.log` in the folder."""
    what = " ".join(f"{type(error).__name__}: {error}".split())
    path = folder / "crash.log"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path.write_text("".join(traceback.format_exception(error)), encoding="utf-8")
    except OSError:
        return f"{doing} crashed: {what}\n{''.join(traceback.format_exception(error))}"
    return f"{doing} crashed: {what}\n  traceback: {path}"
