"""Profiles repeat one another where they must, as Snakemake cannot share their keys."""

from pathlib import Path

import yaml

PROFILES = Path(__file__).resolve().parents[2] / "profiles"


def keys(name: str) -> dict:
    return yaml.safe_load((PROFILES / name / "config.yaml").read_text(encoding="utf-8"))


def test_ci_is_default_without_its_progress_bar() -> None:
    default = keys("default")
    assert default.pop("logger") == "mocap"
    assert keys("ci") == default


def test_slurm_adds_to_ci() -> None:
    slurm, ci = keys("slurm"), keys("ci")
    assert slurm.items() >= ci.items()
    assert {key.partition("-")[0] for key in slurm.keys() - ci.keys()} <= {
        "cores", "executor", "groups", "jobs", "latency", "retries", "slurm"
    }  # fmt: skip
