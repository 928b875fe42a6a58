"""Fuzz every reader: python -m tests.fuzz [--c3d 20000] [--other 10000] [--seed 1] [--ezc3d 0].

The table of outcomes goes to standard output, what is wrong below it; `--list FILE` writes every
mutant that is another valid file. One mutant: --only "text trc" 17 [--write FILE].
"""

import argparse
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.common.errors import Refusal

from . import kinds, pool
from .kinds import Faults, Kind, mutant
from .strict_c3d import MM, Values

EQUAL, REFUSED, OTHER = "read, equal", "refused", "another valid file"
WRONG = ("refused though sound", "silently wrong", "traceback", "crash", "hang")
OUTCOMES = (EQUAL, REFUSED, OTHER, *WRONG)
MEMORY = Path("/dev/shm")  # written to for each mutant
Job = tuple[str, int, int]  # kind, seed, index; index -1: the sound file


def same(one: Values | None, other: Values | None) -> bool:
    """Whether two readings have the same values, to the rounding of float32."""
    if one is None or other is None:
        return False
    return all(_equal(one[key], other[key]) for key in one.keys() & other.keys())


def _values(found: Values | None) -> Values | None:
    """Without how the unit is known: an assumed one is right if the values are, and warned of."""
    return found and {key: value for key, value in found.items() if key != "unit_assumed"}


def _equal(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray) or isinstance(b, float):
        a, b = np.asarray(a, float), np.asarray(b, float)
        return a.shape == b.shape and np.allclose(a, b, rtol=1e-6, atol=1e-9, equal_nan=True)
    return bool(a == b)


def judged(kind: Kind, content: bytes, read: Any = None) -> tuple[str, str]:
    """Outcome of reading a file's bytes, and the message where there is one."""
    folder = Path(tempfile.mkdtemp(prefix="fuzz-", dir=MEMORY if MEMORY.is_dir() else None))
    try:
        (folder / kind.file).write_bytes(content)
        found, why = _read(read or kind.read, folder / kind.file)
    finally:
        shutil.rmtree(folder)
    if found is None and why.startswith("traceback"):
        return "traceback", why
    base, strict = _values(kind.strict(kind.base)), None
    if not same(found, base):
        try:
            with np.errstate(all="ignore"):
                strict = kind.strict(content)
        except Exception:  # a strict reader may stumble over what it does not take
            strict = None
    if found is None:
        return ("refused though sound" if same(strict, base) else REFUSED), why
    if same(found, base):
        return EQUAL, ""
    return (OTHER if same(found, strict) else "silently wrong"), ""


def _read(read: Any, path: Path) -> tuple[Values | None, str]:
    try:
        with np.errstate(all="ignore"):
            return read(path), ""
    except (Refusal, Faults) as refusal:
        lines = str(refusal).split("\n")
        if all(line.isprintable() and len(line) < 2100 for line in lines):
            return None, lines[0]
        return None, f"traceback: no printable line: {str(refusal)[:200]!r}"
    except Exception as error:
        at, where = error.__traceback__, ""
        while at is not None:
            where = f"{Path(at.tb_frame.f_code.co_filename).name}:{at.tb_lineno}"
            at = at.tb_next
        return None, f"traceback: {type(error).__name__} at {where}: {str(error)[:150]}"


def ezc3d_read(labels: Sequence[str], path: Path) -> Values:
    """What ezc3d reads, in mm; its exceptions are refusals."""
    import ezc3d

    try:
        file = ezc3d.c3d(str(path))
        point, data = file["parameters"]["POINT"], file["data"]
        every = point["LABELS"]["value"]
        points = data["points"][:3, [every.index(label) for label in labels]]
        unit = (point["UNITS"]["value"] or [""])[0].strip("\0 ").lower() if "UNITS" in point else ""
        rate = float(file["header"]["points"]["frame_rate"])
    except Exception as error:
        raise Refusal(f"{type(error).__name__}: {error}") from None
    xyz = np.where((points == 0).all(axis=0), np.nan, points) * MM.get(unit, np.nan)
    xyz[:, ~np.isfinite(xyz).all(axis=0)] = np.nan
    return {"position_mm": xyz.transpose(1, 0, 2), "rate": rate, "unit_assumed": not unit}


def judge(known: dict[str, Kind], by_ezc3d: bool, job: Job) -> tuple[str, str, str]:
    """Outcome, message, and what was done; in a child."""
    kind = known[job[0]]
    content, how = (kind.base, "sound") if job[2] < 0 else mutant(kind, *job[1:])
    read = partial(ezc3d_read, kinds.LABELS) if by_ezc3d else None
    return *judged(kind, content, read), how


def run(
    known: dict[str, Kind], jobs: Sequence[Job], workers: int, by_ezc3d: bool = False
) -> tuple[dict[str, Counter[str]], list[tuple[Job, str, str, str]]]:
    """Counts of outcomes by kind; job, outcome, message and damage of what is wrong or other."""
    table: dict[str, Counter[str]] = {name: Counter() for name in dict.fromkeys(j[0] for j in jobs)}
    listed = []
    limit = 10.0 if by_ezc3d else 30.0
    work = partial(judge, known, by_ezc3d)
    for n, (job, result) in enumerate(pool.results(work, jobs, workers, limit), start=1):
        outcome, why, how = (result, "", "") if isinstance(result, str) else result
        table[job[0]][outcome] += 1
        if outcome in WRONG or outcome == OTHER or (job[2] < 0 and outcome != EQUAL):
            listed.append((job, outcome, why, how))
        if n % 1000 == 0:
            print(f"{n} of {len(jobs)}", file=sys.stderr, flush=True)
    return table, listed


def markdown(table: dict[str, Counter[str]]) -> str:
    """The table of outcomes, kinds of C3D and all others summed at the end."""
    total: dict[str, Counter[str]] = {"**all C3D**": Counter(), "**all others**": Counter()}
    for name, counts in table.items():
        total["**all C3D**" if name.startswith("c3d") else "**all others**"].update(counts)
    lines = [f"| kind | mutants | {' | '.join(OUTCOMES)} |", "|---" + "|--:" * 9 + "|"]
    for name, counts in [*table.items(), *((n, c) for n, c in total.items() if c)]:
        cells = [str(counts[outcome]) for outcome in OUTCOMES]
        lines.append(f"| {name} | {counts.total()} | {' | '.join(cells)} |")
    return "\n".join(lines)


def jobs_of(known: dict[str, Kind], n_c3d: int, n_other: int, seed: int) -> list[Job]:
    """Mutants, shared evenly among the kinds; of long files a tenth."""
    jobs: list[Job] = []
    for is_c3d, wanted in ((True, n_c3d), (False, n_other)):
        names = [name for name, kind in known.items() if kind.is_c3d == is_c3d]
        weight = {name: 0.1 if len(known[name].base) > 500_000 else 1.0 for name in names}
        share = wanted / max(1.0, sum(weight.values()))
        for name in names:
            jobs += [(name, seed, i) for i in range(int(np.ceil(share * weight[name])))]
    return jobs


def sound_files(known: dict[str, Kind], workers: int) -> list[str]:
    """What is refused of the sound files: the bases, and recordings by other people."""
    refused = [f"{job[0]}: {outcome}: {why}" for job, outcome, why, _ in
               run(known, [(name, 0, -1) for name in known], workers)[1]]  # fmt: skip
    for path in kinds.real_files():
        try:
            labels = kinds.labels_of(path)
        except Refusal as refusal:
            refused.append(str(refusal))
        else:
            assert labels
    return refused


def main(given: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="tests.fuzz", description=__doc__)
    parser.add_argument("--c3d", type=int, default=20_000, help="mutants of C3D files")
    parser.add_argument("--other", type=int, default=10_000, help="mutants of everything else")
    parser.add_argument("--ezc3d", type=int, default=0, help="mutants of C3D that ezc3d reads too")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--kind", default="", help="only kinds whose name begins with this")
    parser.add_argument("--list", type=Path, help="file for mutants that are another valid file")
    parser.add_argument("--only", nargs=2, metavar=("KIND", "INDEX"))
    parser.add_argument("--write", type=Path)
    asked = parser.parse_args(given)
    known = {name: k for name, k in kinds.every().items() if name.startswith(asked.kind)}
    if asked.only:
        content, how = mutant(known[asked.only[0]], asked.seed, int(asked.only[1]))
        print(how, judged(known[asked.only[0]], content))
        if asked.write:
            asked.write.write_bytes(content)
        return 0
    began = time.monotonic()
    refused = sound_files(known, asked.workers)
    jobs = jobs_of(known, asked.c3d, asked.other, asked.seed)
    table, listed = run(known, jobs, asked.workers)
    print(f"Seed {asked.seed}, {len(jobs)} mutants, {time.monotonic() - began:.0f} s\n")
    print(f"{markdown(table)}\n\nSound files refused: {len(refused)}")
    wrong = [f"{job[0]} {job[2]}: {o}: {how}: {why}" for job, o, why, how in listed if o != OTHER]
    print("\n".join([*refused, *wrong]))
    if asked.list:
        lines = [f"{job[0]}\t{job[2]}\t{how}\n" for job, o, _, how in listed if o == OTHER]
        asked.list.write_text("".join(lines), encoding="utf-8")
    if asked.ezc3d:
        own = {n: k for n, k in known.items() if k.is_c3d and "real" not in n and "seg" not in n}
        table, _ = run(own, jobs_of(own, asked.ezc3d, 0, asked.seed), asked.workers, by_ezc3d=True)
        print(f"\nezc3d\n\n{markdown(table)}")
    return int(bool(refused or wrong))


if __name__ == "__main__":
    sys.exit(main())
