"""The configuration: what the command line may say, and what is refused."""

import copy
import re
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest
import yaml
from mocap_workflow.rows import NAME
from mocap_workflow.startup import check_python, configuration
from running import faults_of
from snakemake.io import PeriodicityDetector

from mocap_metrology.calibration.track import calibration_settings
from mocap_metrology.lighthouse.calibrate import pnp
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings
from mocap_metrology.noise.diagnosis.records import DiagnosisSettings
from mocap_metrology.settings import Settings, checked

ROOT = Path(__file__).resolve().parents[2]
CONFIG = yaml.safe_load((ROOT / "config/config.yaml").read_text(encoding="utf-8"))


def test_a_python_that_the_shell_cannot_start_is_refused() -> None:
    check_python("/Größe–1/.venv/bin/python3.11")
    for sign in " &'(":
        assert repr(sign) in faults_of(check_python, f"/a{sign}b/python")[0]


def changed(**values: Any) -> dict[str, Any]:
    """The project's configuration with `hampel__action=...` laid over it."""
    config = copy.deepcopy(CONFIG)
    for name, value in values.items():
        section, _, key = name.rpartition("__")
        (config[section] if section else config)[key] = value
    return config


def faults(config: dict[str, Any]) -> list[str]:
    return faults_of(checked, config)


def test_the_defaults_of_the_models_are_those_of_the_projects_own_configuration() -> None:
    assert checked(CONFIG) == Settings()


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("hampel__action", False, "off"),
        ("allan__n_taus", "40", 40),
        ("allan__estimators", "oadev, mdev", ["oadev", "mdev"]),
        ("recordings", None, None),
        ("recordings", 7, "7"),
        ("results", "/data//x/./out/", "/data/x/out"),
        ("lighthouse__estimators", "paper-lm, pnp", ["paper-lm", "pnp"]),
        ("lighthouse__simplex_optics", [], []),
        ("lighthouse__lasers_mm", ",".join(12 * "3"), 12 * [3.0]),
        ("diagnosis__cutoffs_hz", "2.5, 6", [2.5, 6.0]),
        ("jansen_studies__speeds_m_s", ["0.2", "1"], [0.2, 1.0]),
    ],
)
def test_values_of_the_command_line(name: str, value: Any, expected: Any) -> None:
    config = checked(changed(**{name: value})).model_dump(mode="json")
    section, _, key = name.rpartition("__")
    found = (config[section] if section else config)[key]
    assert (found, type(found)) == (expected, type(expected))


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("duration_s", "ten", 'duration_s: "ten"; expected a number of seconds >= 1'),
        ("seed", 1.5, "seed: 1.5; expected a whole number >= 0"),
        ("results", "/", 'results: "/"; expected a folder of its own'),
        ("results", "a<b>", 'results: "a<b>"; expected'),
        ("recordings", ["a"], "recordings: ['a']; expected the path of a sheet, or nothing"),
        ("hampel", "off", 'hampel: "off"; expected a section'),
        ("hampel__n_sigma", "-1", 'hampel.n_sigma: "-1"; expected a number > 0'),
        ("hampel__action", "drop", 'hampel.action: "drop"; expected replace, mask or off'),
        ("allan__estimators", ["mdev"], "expected a list of oadev, mdev, hdev"),
        ("allan__estimators", ["oadev", "adev"], "oadev among them"),
        ("allan__max_fraction", 0.6, "allan.max_fraction: 0.6; expected a number > 0 and <= 0.5"),
        ("allan__n_taus", 10**8, "expected a whole number >= 2 and <= 10000"),
        ("diagnosis__cutoffs_hz", [1e9], "expected a list of frequencies in Hz > 0 and <= 1000000"),
        ("psd__overlap", 1, "psd.overlap: 1; expected a number >= 0 and < 1"),
        ("verdict__good_mm", 0.5, "good_mm: 0.5; expected at most verdict.usable_mm (0.25)"),
        ("lighthouse__optics", [], "a list of ideal, factory, estimated, each at most once"),
        ("lighthouse__variant", "vive", "expected auto, crazyflie, libsurvive or"),
        ("lighthouse__lasers_mm", 11 * [0] + [500], "expected nothing, or twelve numbers of mm"),
        ("lighthouse__active_level", 2, "expected 0 or 1"),
        ("simplex_optic", "ideal", "unknown; did you mean lighthouse.simplex_optics?"),
        ("recording", "x", "recording: unknown; did you mean recordings?"),
        ("n_sigma", 4, "n_sigma: unknown; did you mean hampel.n_sigma?"),
        ("xyz", 4, "xyz: unknown; expected one of recordings, calibrations, twins"),
        ("allan__n_sigma", 4, "allan.n_sigma: unknown; did you mean hampel.n_sigma?"),
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


def plain(settings: Any) -> dict[str, Any]:
    """Fields of settings that are called without any, lists as the configuration has them."""
    return {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(settings).items()}


def test_defaults_of_the_package_are_those_of_the_configuration() -> None:
    config = Settings().model_dump(mode="json")
    moving = config["still"]["range_mm"]
    still = {"still_range_mm": moving, "horizon_s": config["verdict"]["horizon_s"]}
    assert DiagnosisSettings().model_dump(mode="json") == config["diagnosis"] | still
    lighthouse = config["lighthouse"] | {"lasers_m": config["lighthouse"]["lasers_mm"]}
    found = plain(CalibrationSettings())
    assert found.pop("priors") == plain(calibration_settings(Settings().lighthouse).priors)
    assert found == {name: lighthouse[name] for name in found}


def test_quick_changes_known_keys_only() -> None:
    quick = yaml.safe_load((ROOT / "config/quick.yaml").read_text(encoding="utf-8"))
    assert set(quick) <= set(CONFIG)
    laid = {
        k: CONFIG[k] | v if isinstance(v, dict) else v for k, v in quick.items()
    }  # as Snakemake
    assert checked(CONFIG | laid).duration_s == 600.0


NAMES = [
    *("a" * 19, "a" * 20, "x" * 200, "ab" * 19 + "a", "ab" * 20, "b" + "ab" * 20, "ab" * 20 + "c"),
    *("take-" + "0" * 19, "take-" + "0" * 20, "0123456789" * 20, "A", "T40-10"),
]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_refused_where_snakemake_sees_an_endless_recursion(name: str) -> None:
    """A job whose wildcard is such a name gets a PeriodicWildcardError."""
    periodic = PeriodicityDetector().is_periodic(name) is not None
    assert bool(re.fullmatch(NAME.pattern, name)) is not periodic


@pytest.mark.parametrize("length", [201, 100_000])
def test_a_name_too_long_is_refused_at_once(length: int) -> None:
    assert not re.fullmatch(NAME.pattern, ("abc" * length)[:length])


def test_pnp_without_opencv_is_refused_before_the_first_job(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    config = changed(lighthouse__estimators="paper-lm, pnp")
    monkeypatch.setattr(pnp, "find_spec", lambda name: None)
    assert faults_of(configuration, config, ROOT) == [
        "config, key lighthouse.estimators: pnp needs OpenCV, which is not installed;"
        " to install it type: make peers"
    ]
    monkeypatch.setattr(pnp, "find_spec", lambda name: object())
    assert configuration(config, ROOT).lighthouse.estimators == ("paper-lm", "pnp")
