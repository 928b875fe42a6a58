"""Recordings by other people: the list of them, and how they are fetched."""

import hashlib
import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from fetch_samples import Sample, read_samples

CONTENT = {"c3d/one.c3d": b"first", "text/a b.csv": b"second"}
PATHS = {"c3d/one.c3d": "data/one.c3d", "text/a b.csv": "of/a b.csv"}
COMMIT = "0123456789ab"


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_args: object) -> None:
        pass


@pytest.fixture
def origin(tmp_path: Path) -> Iterator[str]:
    """A loopback server laid out like raw.githubusercontent.com."""
    served = tmp_path / "served"
    for file, content in CONTENT.items():
        path = served / "owner/name" / COMMIT / PATHS[file]
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(served)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_address[1]}"
    server.shutdown()
    server.server_close()


def write_list(folder: Path, checksums: dict[str, str] | None = None) -> Path:
    rows = [
        f"{file}\towner/name\t{PATHS[file]}\t{COMMIT}\tMIT\t"
        + ((checksums or {}).get(file) or hashlib.sha256(content).hexdigest())
        for file, content in CONTENT.items()
    ]
    sheet = folder / "samples.tsv"
    head = "# a comment\nfile\trepository\tpath\tcommit\tlicence\tsha256\n"
    sheet.write_text(head + "\n".join(rows) + "\n", encoding="utf-8")
    return sheet


def run(root: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, root / "workflow/fetch_samples.py", *arguments]
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=60)


def test_fetched_from_a_server_once(root: Path, tmp_path: Path, origin: str) -> None:
    to, sheet = tmp_path / "to", write_list(tmp_path)
    arguments = ("--to", to, "--sheet", sheet, "--origin", origin)
    first, second = run(root, *arguments), run(root, *arguments)
    assert first.returncode == second.returncode == 0, first.stderr
    assert {f: (to / f).read_bytes() for f in CONTENT} == CONTENT
    assert first.stdout.endswith("2 of 2 sample files, 2 of them new\n")
    assert second.stdout.endswith("2 of 2 sample files, 0 of them new\n")
    (to / "c3d/one.c3d").write_bytes(b"damaged")
    assert run(root, *arguments).stdout.endswith("1 of them new\n")
    assert (to / "c3d/one.c3d").read_bytes() == b"first"


def test_another_content_or_no_file_is_refused(root: Path, tmp_path: Path, origin: str) -> None:
    to, sheet = tmp_path / "to", write_list(tmp_path, {"c3d/one.c3d": "0" * 64})
    (tmp_path / "served/owner/name" / COMMIT / "of/a b.csv").unlink()
    done = run(root, "--to", to, "--sheet", sheet, "--origin", origin)
    assert done.returncode == 1
    assert [line.split(": ")[0] for line in done.stderr.splitlines()] == list(CONTENT)
    assert "404" in done.stderr.splitlines()[1]
    assert not [path for path in to.rglob("*") if path.is_file()]


def test_copied_from_a_folder(root: Path, tmp_path: Path) -> None:
    have, to = tmp_path / "have", tmp_path / "to"
    (have / "c3d").mkdir(parents=True)
    (have / "c3d/one.c3d").write_bytes(b"first")
    done = run(root, "--to", to, "--sheet", write_list(tmp_path), "--from", have)
    assert done.returncode == 1
    assert done.stderr == f"text/a b.csv: not in {have}\n"
    assert (to / "c3d/one.c3d").read_bytes() == b"first"


def test_every_sample_has_its_origin() -> None:
    samples = read_samples()
    assert len({sample.file for sample in samples}) == len(samples) == 91
    for sample in samples:
        assert re.fullmatch(r"[\w.-]+/[\w.-]+", sample.repository)
        assert re.fullmatch(r"[0-9a-f]{12}|[0-9a-f]{40}", sample.commit)
        assert re.fullmatch(r"[0-9a-f]{64}", sample.sha256)
        assert sample.path and sample.licence
    spaced = Sample("f", "a/b", "c d/e.c3d", "1" * 12, "MIT", "")
    assert spaced.url().endswith("/a/b/111111111111/c%20d/e.c3d")


def test_the_samples_are_those_of_the_list(samples: Path) -> None:
    for sample in read_samples():
        assert hashlib.sha256((samples / sample.file).read_bytes()).hexdigest() == sample.sha256
