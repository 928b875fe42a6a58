"""The rule by which lines are changed, and which tests reach a line that no trace sees."""

from __future__ import annotations

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


def test_constants_and_kernels_are_reached_through_what_uses_them(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text(
        "BLOCK = 3\n\n\n@njit\ndef kernel():\n    return BLOCK\n\n\ndef other():\n    pass\n"
    )
    (tmp_path / "b.py").write_text(
        "from mocap_metrology.a import kernel\n\n\nclass C:\n    N = 1\n\n    def use(self):\n"
        "        return kernel()\n\n\ndef more():\n    return C.N\n"
    )
    units = Units(tmp_path)
    assert units.traced("a.py", 1) == units.traced("a.py", 6) == {"b.py:C.use"}
    assert units.traced("a.py", 10) == {"a.py:other"}
    assert units.traced("b.py", 5) == {"b.py:more"}
