"""Lines of code by room, all and without blanks, comments and docstrings, of one commit or two:

python -m benchmarks.lines 63d603a HEAD
"""

from __future__ import annotations

import ast
import io
import subprocess
import tokenize
from collections import Counter
from collections.abc import Iterator

from benchmarks import arguments

SUFFIXES = (".py", ".smk", "Snakefile", ".html", ".css", ".js", ".toml")
PLACES = ("src", "workflow", "benchmarks", "tests")


def git(*arguments: str) -> bytes:
    return subprocess.run(["git", *arguments], check=True, capture_output=True).stdout


def room(path: str) -> str:
    """`src/present` of src/mocap_metrology/present/..., else the first folder."""
    first, *rest = path.split("/")
    return f"src/{rest[1]}" if first == "src" and len(rest) > 2 else first


def code_lines(path: str, text: str) -> int:
    """Lines that hold code; of other languages than Python those that are not blank."""
    if not path.endswith(".py"):
        return sum(bool(line.strip()) for line in text.splitlines())
    skipped = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT)
    held = {
        number
        for token in tokenize.generate_tokens(io.StringIO(text).readline)
        if token.type not in (*skipped, tokenize.ENDMARKER)
        for number in range(token.start[0], token.end[0] + 1)
    }
    return len(held - set(_docstrings(ast.parse(text))))


def _docstrings(tree: ast.Module) -> Iterator[int]:
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    for node in ast.walk(tree):
        if isinstance(node, kinds) and ast.get_docstring(node) is not None:
            yield from range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1)


def counts(commit: str) -> tuple[Counter[str], Counter[str]]:
    """Lines by room, and those that hold code."""
    every: Counter[str] = Counter()
    code: Counter[str] = Counter()
    for path in git("ls-tree", "-r", "--name-only", commit, *PLACES).decode().split("\n"):
        if path.endswith(SUFFIXES):
            text = git("show", f"{commit}:{path}").decode()
            for name in {room(path), path.split("/")[0]}:
                every[name] += len(text.splitlines())
                code[name] += code_lines(path, text)
    return every, code


if __name__ == "__main__":
    found = {commit: counts(commit) for commit in arguments(__doc__, commits=("HEAD",))["commits"]}
    print("room".ljust(18), *(f"{commit[:12]:>12} {'code':>7}" for commit in found))
    for name in sorted({name for every, _ in found.values() for name in every}):
        cells = (f"{every[name]:12d} {code[name]:7d}" for every, code in found.values())
        print(name.ljust(18), *cells)
