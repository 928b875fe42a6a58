"""The configuration: what the command line may say, and what is refused."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest
import yaml
from lib.configuration import checked, leaves, load_schema
from lib.faults import Faults
from lib.startup import any_of

ROOT = Path(__file__).resolve().parents[2]
SCHEMA = load_schema(ROOT / "workflow/schemas/config.schema.yaml")
CONFIG = yaml.safe_load((ROOT / "config/config.yaml").read_text(encoding="utf-8"))


def changed(**values: Any) -> dict[str, Any]:
    """The project's configuration with `hampel__action=...` laid over it."""
    config = copy.deepcopy(CONFIG)
    for name, value in values.items():
        section, _, key = name.rpartition("__")
        (config[section] if section else config)[key] = value
    return config


def faults(config: dict[str, Any]) -> list[str]:
    with pytest.raises(Faults) as caught:
        checked(config, SCHEMA)
    return caught.value.lines


def test_the_projects_own_configuration_is_right_and_whole() -> None:
    config = checked(CONFIG, SCHEMA)
    assert config["hampel"] == {"half_window_s": 1.0, "n_sigma": 3.0, "action": "replace"}
    assert config["duration_s"] == 32400.0
    assert list(config) == list(SCHEMA["properties"])


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("hampel__n_sigma", "4", 4.0),
        ("hampel__action", False, "off"),
        ("hampel__action", "mask", "mask"),
        ("allan__n_taus", "40", 40),
        ("allan__n_taus", 40.0, 40),
        ("allan__estimators", "oadev, mdev", ["oadev", "mdev"]),
        ("psd__segment_s", "1e2", 100.0),
        ("second_opinion", "no", False),
        ("second_opinion", "True", True),
        ("recordings", None, None),
        ("recordings", "", None),
        ("recordings", 7, "7"),
        ("twins", None, None),
        ("results", 2024, "2024"),
        ("results", "out/", "out"),
        ("results", "/data//x/./out/", "/data/x/out"),
        ("duration_s", "600", 600.0),
        ("lighthouse__active_level", "0", 0),
        ("lighthouse__estimators", "paper-lm, pnp", ["paper-lm", "pnp"]),
        ("lighthouse__simplex_optics", [], []),
        ("lighthouse__lasers_mm", "null", None),
        ("lighthouse__lasers_mm", ",".join(12 * "3"), 12 * [3.0]),
        ("lighthouse__lm_weights", "none", "none"),
    ],
)
def test_values_of_the_command_line(name: str, value: Any, expected: Any) -> None:
    config = checked(changed(**{name: value}), SCHEMA)
    section, _, key = name.rpartition("__")
    found = (config[section] if section else config)[key]
    assert (found, type(found)) == (expected, type(expected))


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("duration_s", None, "duration_s: nothing; expected a number of seconds >= 1"),
        ("duration_s", "ten", 'duration_s: "ten"; expected a number of seconds >= 1'),
        ("duration_s", 0, "duration_s: 0; expected"),
        ("duration_s", float("inf"), "duration_s: inf; expected"),
        ("seed", 1.5, "seed: 1.5; expected a whole number >= 0"),
        ("seed", True, "seed: yes; expected a whole number >= 0"),
        ("seed", -1, "seed: -1; expected"),
        ("results", None, "results: nothing; expected a folder of its own"),
        ("results", "/", 'results: "/"; expected a folder of its own'),
        ("results", "..", 'results: ".."; expected'),
        ("results", 1.5, "results: 1.5; expected"),
        ("results", "a<b>", 'results: "a<b>"; expected'),
        ("recordings", ["a"], "recordings: ['a']; expected the path of a sheet, or nothing"),
        ("hampel", None, "hampel: nothing; expected a section with half_window_s, n_sigma, action"),
        ("hampel", "off", 'hampel: "off"; expected a section'),
        ("hampel__n_sigma", "-1", 'hampel.n_sigma: "-1"; expected a number > 0'),
        ("hampel__n_sigma", "nan", 'hampel.n_sigma: "nan"; expected a number > 0'),
        ("hampel__action", "drop", 'hampel.action: "drop"; expected replace, mask or off'),
        ("allan__estimators", ["mdev"], "expected a list of oadev, mdev, hdev"),
        ("allan__estimators", ["oadev", "adev"], "oadev among them"),
        ("allan__estimators", ["oadev", "oadev"], "each at most once"),
        ("allan__max_fraction", 0.6, "allan.max_fraction: 0.6; expected a number > 0 and <= 0.5"),
        ("allan__n_taus", 1, "expected a whole number >= 2"),
        ("psd__overlap", 1, "psd.overlap: 1; expected a number >= 0 and < 1"),
        ("second_opinion", "maybe", 'second_opinion: "maybe"; expected true or false'),
        ("gaussian__n_bins", 3, "expected a whole number >= 4"),
        ("verdict__good_mm", 0.5, "good_mm: 0.5; expected at most verdict.usable_mm (0.25)"),
        ("verdict__usable_missing", 0, "0.01; expected at most verdict.usable_missing (0)"),
        ("lighthouse__estimators", ["paper"], "paper-lm among them"),
        ("lighthouse__optics", [], "expected a list of ideal, factory, each at most once"),
        ("lighthouse__variant", "vive", "expected crazyflie, libsurvive or astrobee"),
        ("lighthouse__lasers_mm", [1, 2, 3], "expected nothing, or twelve numbers of mm"),
        ("lighthouse__lasers_mm", 11 * [0] + [500], "expected nothing, or twelve numbers of mm"),
        ("lighthouse__active_level", 2, "expected 0 or 1"),
        ("simplex_optic", "ideal", "unknown; did you mean lighthouse.simplex_optics?"),
        ("recording", "x", "recording: unknown; did you mean recordings?"),
        ("n_sigma", 4, "n_sigma: unknown; did you mean hampel.n_sigma?"),
        ("xyz", 4, "xyz: unknown; expected one of recordings, calibrations, twins"),
        ("hampel__nsigma", 4, "hampel.nsigma: unknown; did you mean n_sigma?"),
    ],
)
def test_a_wrong_value_is_one_line(name: str, value: Any, expected: str) -> None:
    lines = faults(changed(**{name: value}))
    assert len(lines) == 1, lines
    assert lines[0].startswith("config, key ")
    assert expected in lines[0]


def test_all_wrong_values_come_at_once() -> None:
    config = changed(seed="x", hampel__n_sigma=0, psd__overlap=2, colour="red")
    del config["still"]["range_mm"]
    assert [line.split(":")[0] for line in faults(config)] == [
        "config, key colour",
        "config, key seed",
        "config, key hampel.n_sigma",
        "config, key psd.overlap",
        "config, key still.range_mm",
    ]


def test_every_key_and_column_is_described_for_users() -> None:
    manual = (ROOT / "config/README.md").read_text(encoding="utf-8")
    for name in leaves(SCHEMA):
        assert f"| `{name}` |" in manual, name
    for sheet in ("recordings", "calibrations"):
        for column in load_schema(ROOT / f"workflow/schemas/{sheet}.schema.yaml")["columns"]:
            assert f"| `{column}` |" in manual, column


def test_quick_changes_known_keys_only() -> None:
    quick = yaml.safe_load((ROOT / "config/quick.yaml").read_text(encoding="utf-8"))
    assert set(quick) <= set(CONFIG)
    laid = {
        k: CONFIG[k] | v if isinstance(v, dict) else v for k, v in quick.items()
    }  # as Snakemake
    assert checked(CONFIG | laid, SCHEMA)["duration_s"] == 600.0


def test_names_become_patterns_of_themselves() -> None:
    import re

    pattern = any_of(["a.b", "a", "a.b"])
    assert [bool(re.fullmatch(pattern, name)) for name in ("a.b", "a", "axb", "")] == [1, 1, 0, 0]
    assert not re.fullmatch(any_of([]), "")
