"""The rule by which lines are changed, and which tests reach a line that no trace sees."""

from pathlib import Path

from .changes import apply, changes
from .reach import Units

SOURCE = '''"""Text with 1 < 2."""
LIMIT = 0.5  # 3 > 2


def f(x: int | None = None, n: int = 2) -> list[int]:
    if x is None or not n <= LIMIT:
        raise ValueError(f"{n + 1}: expected 3")
    return [min(-x, µ - n)]
'''


def test_operators_constants_signs_and_names_are_changed_and_no_types_or_messages() -> None:
    lines = SOURCE.splitlines()
    made: dict[int, set[str]] = {}
    for change in changes(SOURCE):
        (number,) = (
            k
            for k, (new, old) in enumerate(zip(apply(SOURCE, change).splitlines(), lines, strict=1))
            if new != old
        )
        made.setdefault(number + 1, set()).add(apply(SOURCE, change).splitlines()[number].strip())
    assert made == {
        2: {f"LIMIT = {value}  # 3 > 2" for value in ("1.0", "0.25", "500.0")},
        5: {f"def f(x: int | None = None, n: int = {value}) -> list[int]:" for value in (1, 3)},
        6: {
            "if x is not None or not n <= LIMIT:",
            "if x is None and not n <= LIMIT:",
            "if x is None or n <= LIMIT:",
            "if x is None or not n < LIMIT:",
        },
        8: {"return [max(-x, µ - n)]", "return [min(x, µ - n)]", "return [min(-x, µ + n)]"},
    }


def test_constants_and_kernels_are_reached_through_statements_that_use_them(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text(
        "BLOCK = 3\n\n\n@njit\ndef kernel():\n    return BLOCK\n\n\ndef other(k=2):\n    pass\n"
    )
    (tmp_path / "b.py").write_text(
        "from mocap_metrology.a import kernel\n\n\nclass C:\n    N = 1\n\n    def use(self, x):\n"
        "        if x > 2:\n            return kernel()\n        return x\n\n\n"
        "def more():\n    return C.N\n"
    )
    units = Units(tmp_path)

    def marked(module: str, line: int) -> set[str]:
        return units.depending(module, line) & set(units.marked)

    assert marked("a.py", 1) == marked("a.py", 6) == {"b.py:C.use 1"}
    assert marked("a.py", 9) == marked("a.py", 10) == {"a.py:other 0"}
    assert marked("b.py", 5) == {"b.py:more 0"}
    assert marked("b.py", 8) == {"b.py:C.use 0"}


def test_marks_note_statements_that_run(tmp_path: Path) -> None:
    path = tmp_path / "m.py"
    path.write_text('def f(x):\n    """Text."""\n    if x:\n        return 1\n    return 2\n')
    units, space = Units(tmp_path), {"__reached__": bytearray(3)}
    exec(compile(units.mark(path.read_bytes(), "m.py"), "m.py", "exec"), space)
    assert space["f"](0) == 2
    assert list(space["__reached__"]) == [1, 0, 1]
