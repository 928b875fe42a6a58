"""Why a job failed, in one line and the place of its log."""

from __future__ import annotations

import re
from pathlib import Path

SAID = re.compile(r"^\d\d:\d\d:\d\d ERROR (.+)$", re.MULTILINE)  # by workflow/scripts/step.py
PLACE = re.compile(r'^ +File "(.+)", line (\d+), in (.+)$', re.MULTILINE)
ENDED = re.compile(r"(died with <.+>|returned non-zero exit status -?\d+)\.?$", re.MULTILINE)
TRACEBACK = "Traceback (most recent call last)"


def why_failed(job: str, log: Path | None, ended: str = "") -> list[str]:
    """What the log of a job says of its end: a refusal, a crash with its place, or what ended it.

    job: how the job is called; ended: how its process ended, as Snakemake says it.
    """
    try:
        text = log.read_text(encoding="utf-8", errors="replace").rstrip() if log else ""
    except OSError:
        text = ""
    said = SAID.findall(text)
    if said and TRACEBACK not in text:
        return [f"{job}: {said[-1]}"]
    if said or TRACEBACK in text:
        what = said[-1] if said else text.splitlines()[-1]
        place = PLACE.findall(text)
        where = f", in {Path(place[-1][0]).name}, line {place[-1][1]}" if place else ""
        return [f"{job} crashed: {what.removesuffix(f' (see {log})')}{where}", f"  log: {log}"]
    messages = ENDED.findall(ended)
    last = f": {text.splitlines()[-1]}" if text else ""
    where = f"  log: {log}" if text else "  its log is empty"
    return [f"{job} ended: {messages[-1] if messages else 'without a message'}{last}", where]
