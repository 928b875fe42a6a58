"""Profiles repeat one another where they must, as Snakemake cannot share their keys."""

from __future__ import annotations

from pathlib import Path

import yaml
from test_rules import rules

SUBMITTED = {"clean", "take_bar", "sweeps", "claims", "jansen_study"}
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


def test_on_a_cluster_a_rule_is_grouped_local_or_worth_a_submission(root: Path) -> None:
    """`SUBMITTED`: what the others wait for, and what takes longest of the rest."""
    grouped, found = keys("slurm")["groups"], rules(root)
    local = {name for name, body in found.items() if "    localrule: True\n" in body}
    assert found.keys() == grouped.keys() | local | SUBMITTED
    assert not local & grouped.keys()


def test_quick_only_names_its_configuration() -> None:
    assert keys("quick") == {"configfile": ["config/quick.yaml"]}


def test_no_profile_holds_configuration_values() -> None:
    for profile in PROFILES.iterdir():
        assert "config" not in keys(profile.name)
