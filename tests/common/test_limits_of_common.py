"""Rules of the common parts at their limits, their messages, and YAML and JSON of users."""

import math
from pathlib import Path
from typing import Annotated, Literal

import pytest
import yaml
from pydantic import AfterValidator, Field

from mocap_metrology.common import compiled, faults, paths, sections
from mocap_metrology.common.documents import load_yaml
from mocap_metrology.common.errors import Refusal, one_line, printable


def test_kernels_of_a_user_are_in_the_folder_that_xdg_names(monkeypatch, tmp_path: Path) -> None:
    """A relative path there is invalid (XDG Base Directory Specification)."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert compiled._candidates()[1:] == [tmp_path / "mocap-metrology"]
    monkeypatch.setenv("XDG_CACHE_HOME", "here")
    assert compiled._candidates()[1:] == []


class Some(sections.Section):
    flag: bool = True
    n: int = Field(3, ge=1, le=9)
    share: float = Field(0.5, gt=0, lt=1)
    mode: Literal["off", "on", "auto"] = "on"
    note: str = ""
    level_mm: float | None = None
    tau_s: float = Field(1.0, ge=0)
    kinds: Annotated[
        tuple[Literal["a", "b", "c"], ...], AfterValidator(sections.Unique("a", 2))
    ] = ("a", "b")  # fmt: skip


@pytest.mark.parametrize(
    ("key", "value", "read"),
    [
        *(("flag", word, True) for word in ("yes", " ON ", "true", True)),
        *(("flag", word, False) for word in ("no", "off", "False", False)),
        *(("n", value, int(value)) for value in (1, "9", 3.0)),
        *(("share", value, float(value)) for value in (0.999, " 1e-3", 0.001)),
        *(("mode", value, "off") for value in ("off", False)),
        ("note", 2024, "2024"),
        *(("level_mm", value, None) for value in ("", "null", None)),
        *(("level_mm", value, 1.5) for value in ("1.5", 1.5)),
        ("tau_s", 0, 0.0),
        *(("kinds", value, ("a", "c")) for value in ("a, c", ["a", "c"])),
    ],
)
def test_a_setting_as_text_or_as_a_number(key: str, value: object, read: object) -> None:
    found = getattr(Some(**{key: value}), key)
    assert found == read and type(found) is type(read)


@pytest.mark.parametrize(
    ("key", "wrong", "expected"),
    [
        ("flag", ["maybe", 1, None], "true or false"),
        ("n", [0, 10, "2.5", True, None], "a whole number from 1 to 9"),
        ("share", [0, 1, "x", math.nan, math.inf, 10**400], "a number > 0 and < 1"),
        ("mode", ["of", 0, None], "off, on or auto"),
        ("tau_s", [-0.001, "1 s"], "a number of seconds >= 0"),
        ("kinds", ["a", "b, c", "a, a", "a, d"],
         "a list of a, b, c, each at most once, a among them"),
    ],
)  # fmt: skip
def test_a_setting_out_of_its_range(key: str, wrong: list[object], expected: str) -> None:
    assert sections.expected(key, Some.model_fields[key]) == expected
    for value in wrong:
        with pytest.raises(ValueError, match=key):
            Some(**{key: value})


def test_messages_are_one_line_of_a_limited_length() -> None:
    assert one_line("a\n  b\tc") == str(Refusal("a\n  b\tc")) == "a b c"
    assert one_line("x" * 2000) == "x" * 2000
    assert one_line("x" * 1000 + "y" * 1001) == "x" * 1000 + " [...] " + "y" * 1000
    assert faults.shortened("x" * 300) == "x" * 300
    assert faults.shortened("x" * 301) == "x" * 295 + "[...]"
    assert faults.quoted("x" * 78) == '"' + "x" * 78 + '"'
    assert faults.quoted("x" * 79) == '"' + "x" * 74 + "[...]"
    assert [faults.quoted(value) for value in (None, "", True, False, 3)] == [
        "nothing", "nothing", "yes", "no", "3",
    ]  # fmt: skip
    assert faults.unknown("sed", ["seed"]) == "unknown; did you mean seed?"
    assert faults.unknown("x", ["seed", "n"]) == "unknown; expected one of seed, n"
    assert faults.unknown("x", []) == "unknown; expected nothing here"
    assert printable("−2\u202f170.9 µm\u00a0x") == "−2\u202f170.9 µm\u00a0x"
    assert printable("a\x1b[31mb\u200fc\nd") == "a\\x1b[31mb\\u200fc\\nd"


def test_paths_of_windows(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a").mkdir()
    (tmp_path / "a/b.c3d").touch()
    for text, said in (
        ("C:\\data\\take 1.c3d", "in WSL that is /mnt/c/data/take 1.c3d"),
        ("d:/x/", "in WSL that is /mnt/d/x"),
        ("a\\b.c3d", "with slashes it is a/b.c3d"),
        ("a\\c.c3d", ""),
        ("a/b.c3d", ""),
    ):
        assert paths.of_windows(text) == said
    assert paths.is_file("a/b.c3d") and paths.exists("a") and not paths.is_file("a")
    assert not paths.exists("x" * 300) and not paths.is_file("x" * 300)


NINES = "9" * 5000


def repeated(first: str, later: str) -> str:
    """Ten million times the first: each further line has ten aliases of the line before."""
    lines = [f"a{k}: &a{k} " + later.format(", ".join([f"*a{k - 1}"] * 10)) for k in range(1, 8)]
    return "\n".join([f"a0: &a0 {first}", *lines])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (repeated("[x]", "[{}]"), "line 7: too much"),
        (repeated("{k: 1}", "{{<<: [{}]}}"), "line 7: too much"),
        (
            "\n".join(["a0: &a0 [x]", *(f"a{k}: &a{k} [*a{k - 1}]" for k in range(1, 5000))]),
            "too m",
        ),
        ("a: &a [*a]", "line 1: too much"),
        ("[" * 100_000, "line 1: nested 101 deep"),
        ("".join(" " * k + "a:\n" for k in range(2000)), "nested 101 deep"),
        (f"0x{NINES}", "line 1: a number of 5002 digits"),
        ("a: 1\nb: 2\na: 3", "line 3: key a is repeated"),
        ("- {'1': 1, 1: 2}", "line 1: key 1 is repeated"),
        ("a: 2024-13-45", "month must be in 1..12"),
        ("a: !!int x", "invalid literal"),
        ("a: [", "expected"),
        ("a\tb: 1", "cannot start any token"),  # libyaml reads it
        ("a: 1\n\ufeff\nb: 2", "line 2: a byte order mark"),
        ("\n\ufeffb: 2", "line 2: a byte order mark"),
        ("\ufeffa: 1\n\ufeffb: 2", "line 2: a byte order mark"),  # a second one
        ("a: !!python/object:os.system x", "could not determine a constructor"),
    ],
)
def test_yaml_that_is_no_value(text: str, expected: str) -> None:
    with pytest.raises(ValueError, match=expected) as refused:
        load_yaml(text)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "text",
    ["", "~", "a: 1e-6\nb: [1, 2.5, yes]", "d: &d {a: 1}\ne: {<<: *d, a: 2}\nf: *d", "? a\n? b",
     f"a: {'x' * 5000}\nb: [0x1F, 017, 1_000, 1:30]"],
)  # fmt: skip
def test_any_other_yaml_is_that_of_pyyaml(text: str) -> None:
    assert load_yaml(text) == yaml.safe_load(text)
