"""What is made of the models is current: tables of the manual, and JSON Schemas for editors."""

import json
from typing import Any

import jsonschema
import pytest
import yaml
from mocap_workflow import document

SCHEMAS = {name: json.loads(text) for name, text in document.schemas().items()}


def test_the_tables_of_the_manual_are_current() -> None:
    text = document.MANUAL.read_text(encoding="utf-8")
    assert document.manual(text) == text, "type: make docs"


def test_the_schemas_are_current() -> None:
    assert {path.name for path in document.SCHEMAS.iterdir()} == set(SCHEMAS)
    for name, text in document.schemas().items():
        assert (document.SCHEMAS / name).read_text(encoding="utf-8") == text, "type: make docs"


def validator(name: str) -> Any:
    return jsonschema.Draft202012Validator(SCHEMAS[f"{name}.schema.json"])


@pytest.mark.parametrize("name", ["config", "twins"])
def test_the_projects_own_files_fit_their_schema(name: str) -> None:
    text = (document.ROOT / f"config/{name}.yaml").read_text(encoding="utf-8")
    values = yaml.safe_load(text)
    assert validator(name).is_valid(values)
    assert not validator(name).is_valid(values | {"colour": 1})


def test_what_does_not_fit_a_schema() -> None:
    config = yaml.safe_load((document.ROOT / "config/config.yaml").read_text(encoding="utf-8"))
    for wrong in ({"n_sigma": 0}, {"action": "drop"}, {"colour": 1}):
        assert not validator("config").is_valid(config | {"hampel": config["hampel"] | wrong})
    for wrong in ({"seed": 1, "dropout": 2}, {"seed": -1}, {"crump": {"decay_s": 0}}, {"a": 1}):
        assert not validator("twins").is_valid({"twins": {"T": wrong}}), wrong
