"""`python -m tests.frozen [name ...]`: store the results anew, and say what changed."""

import json
import logging
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "workflow"), str(ROOT / "workflow/scripts")]

from . import digest, groups, test_doses  # noqa: E402
from .test_frozen import MADE, STORED, of_samples, stored  # noqa: E402

logging.disable(logging.WARNING)
STORED.mkdir(exist_ok=True)
every = MADE | test_doses.MADE
names = sys.argv[1:] or [*every, *groups.REAL]
for name in names:
    with tempfile.TemporaryDirectory() as folder:
        found = every[name](folder=Path(folder)) if name in every else of_samples(name)
    if found is None:
        print(f"{name}: left as it is, as the sample recordings are missing")
        continue
    path = stored(name)
    before = json.loads(path.read_text()) if path.is_file() else {}
    lines = digest.changed(found, before) if before else [f"{len(found)} values are new"]
    print(f"{name}: {len(lines)} changes", *lines, sep="\n  ", flush=True)
    kept = {key: digest.stored(value) for key, value in sorted(found.items())}
    rows = (f"{json.dumps(k)}: {json.dumps(v, ensure_ascii=False)}" for k, v in kept.items())
    path.write_text("{\n" + ",\n".join(rows) + "\n}\n", encoding="utf-8")
