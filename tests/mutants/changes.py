"""Every change to a source that the rule makes: operators, comparisons, constants, signs, names."""

import ast
import re
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

OPERATORS = {
    **{"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="},
    **{"is not": "is", "is": "is not", "not in": "in", "in": "not in"},
    **{"+": "-", "-": "+", "*": "/", "/": "*", "//": "*", "%": "*", "**": "*", "@": "*"},
    **{"&": "|", "|": "&", "^": "|", "<<": ">>", ">>": "<<", "and": "or", "or": "and"},
}
OPPOSITE = [
    *("min max", "minimum maximum", "fmin fmax", "argmin argmax", "nanmin nanmax", "any all"),
    *("floor ceil", "sin cos", "zeros ones", "isnan isfinite", "cumsum cumprod"),
]
NAMES = dict(pair.split()[::step] for pair in OPPOSITE for step in (1, -1))
SYMBOL = re.compile(r"is\s+not|not\s+in|is|in|and|or|\*\*|//|<<|>>|[<>=!]=|[-+*/%@&|^<>]")
# Types and what is only read by people: there a change has no meaning, or that of a word
UNREAD = (ast.Raise, ast.JoinedStr, ast.Import, ast.ImportFrom)


class Change(NamedTuple):
    """One change: where the text to replace begins and ends (bytes of the line), old and new."""

    line: int
    start: int
    end: int
    old: str
    new: str


def changes(source: str) -> list[Change]:
    """All changes that the rule makes to a source, in the order of the text."""
    lines = [line.encode() for line in source.splitlines()]
    return sorted(set(_below(ast.parse(source), lines)))


def _below(node: ast.AST, lines: list[bytes]) -> Iterator[Change]:
    if isinstance(node, UNREAD) or _is_type(node):
        return
    if isinstance(node, ast.FunctionDef) and node.name == "warm_up":  # compiles, without a result
        return
    yield from _of(node, lines)
    for name, value in ast.iter_fields(node):
        if name not in ("annotation", "returns", "decorator_list", "type_params"):
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    yield from _below(child, lines)


def _is_type(node: ast.AST) -> bool:
    """Whether a statement names a type, as `Pair = tuple[int, int] | None`, or checks for types."""
    if isinstance(node, ast.Assign) and isinstance(node.value, ast.BinOp | ast.Subscript):
        names = {n.id for n in ast.walk(node.value) if isinstance(n, ast.Name)}
        return bool(names & {"tuple", "list", "dict", "Literal", "Callable", "NDArray", "Mapping"})
    return isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"


def _of(node: ast.AST, lines: list[bytes]) -> Iterator[Change]:
    if isinstance(node, ast.Compare):
        parts = [node.left, *node.comparators]
    elif isinstance(node, ast.BoolOp):
        parts = node.values
    elif isinstance(node, ast.BinOp):
        parts = [node.left, node.right]
    else:
        parts = []
    for left, right in pairwise(parts):
        yield from _operator(left, right, lines)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
        old = "-" if isinstance(node.op, ast.USub) else "not "
        if lines[node.lineno - 1][node.col_offset :].startswith(old.encode()):
            yield Change(node.lineno, node.col_offset, node.col_offset + len(old), old, "")
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        for new in _constants(node.value):
            yield _replaced(node, lines, new)
    if isinstance(node, ast.Name) and node.id in NAMES:
        yield _replaced(node, lines, NAMES[node.id])
    if isinstance(node, ast.Attribute) and node.attr in NAMES and node.end_lineno == node.lineno:
        yield _replaced(node, lines, f"{ast.unparse(node.value)}.{NAMES[node.attr]}")


def _replaced(node: ast.expr, lines: list[bytes], new: str) -> Change:
    start, end = node.col_offset, node.end_col_offset or 0
    return Change(node.lineno, start, end, lines[node.lineno - 1][start:end].decode(), new)


def _constants(value: float) -> list[str]:
    """Off by one, twice and half, another unit; the opposite."""
    if isinstance(value, bool):
        return [str(not value)]
    if isinstance(value, int):
        scaled = [2 * value, value // 2, 1000 * value] if value >= 100 else []
        return [str(n) for n in scaled or [value + 1, *([value - 1] if value else [])]]
    return [repr(factor * value) for factor in (2.0, 0.5, 1e3)] if value else ["1.0"]


def _operator(left: ast.expr, right: ast.expr, lines: list[bytes]) -> Iterator[Change]:
    """The operator between two operands, which may stand on the next line, in brackets."""
    for number in range(left.end_lineno or 0, right.lineno + 1):
        line = lines[number - 1]
        start = (left.end_col_offset or 0) if number == left.end_lineno else 0
        text = line[start : right.col_offset if number == right.lineno else None].decode()
        found = SYMBOL.search(text.partition("#")[0])
        if found:
            old = " ".join(found.group().split())
            start += len(text[: found.start()].encode())
            yield Change(number, start, start + len(found.group().encode()), old, OPERATORS[old])
            return


def apply(source: str, change: Change) -> str:
    """The source with one change."""
    lines = source.splitlines(keepends=True)
    line = lines[change.line - 1].encode()
    lines[change.line - 1] = (
        line[: change.start] + change.new.encode() + line[change.end :]
    ).decode()
    return "".join(lines)
