"""YAML and JSON of users: what PyYAML and json read otherwise, or not to the end."""

import json

import pytest
import yaml

from mocap_metrology.common.documents import load_json, load_yaml

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
        ("a: 1\n\ufeff\nb: 2", "line 2: a byte order mark"),
        ("a: !!python/object:os.system x", "could not determine a constructor"),
    ],
)
def test_yaml_that_is_no_value(text: str, expected: str) -> None:
    with pytest.raises(ValueError, match=expected) as refused:
        load_yaml(text)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('{"a": {"b": 1, "b": 2}}', "key b is repeated"),
        ("[" * 100_000, "nested too deeply"),
        ("{", "Expecting property name"),
    ],
)
def test_json_that_is_no_value(text: str, expected: str) -> None:
    with pytest.raises(ValueError, match=expected):
        load_json(text)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "~",
        "a: 1e-6\nb: [1, 2.5, yes]",
        "d: &d {a: 1}\ne: {<<: *d, a: 2}\nf: *d",
        "? a\n? b",
        f"a: {'x' * 5000}\nb: [0x1F, 017, 1_000, 1:30]",
    ],
)
def test_any_other_yaml_is_that_of_pyyaml(text: str) -> None:
    assert load_yaml(text) == yaml.safe_load(text)


def test_any_other_json_is_that_of_json() -> None:
    value = {"a": [1, -2.5, None, True, {"b": "c"}], "d": 10**50}
    assert load_json(json.dumps(value)) == value
