"""Rules of the common parts at their limits."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import pytest
from pydantic import Field

from mocap_metrology.common import compiled
from mocap_metrology.common.faults import Faults
from mocap_metrology.common.sections import Section, choices_of
from mocap_metrology.settings import checked


def test_kernels_of_a_user_are_in_the_folder_that_xdg_names(monkeypatch, tmp_path: Path) -> None:
    """A relative path there is invalid (XDG Base Directory Specification)."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert compiled._candidates()[1:] == [tmp_path / "mocap-metrology"]
    monkeypatch.setenv("XDG_CACHE_HOME", "here")
    assert compiled._candidates()[1:] == []


def test_choices_are_those_of_a_literal_alone_or_in_a_list() -> None:
    assert choices_of(Literal["a", "b"]) == ("a", "b")
    assert choices_of(tuple[Literal["a", 1], ...]) == ("a", "1")
    assert choices_of(float) == choices_of(tuple[float, ...]) == ()


@pytest.mark.parametrize(
    ("config", "fault"),
    [
        ({"sed": 1}, "config, key sed: unknown; did you mean seed?"),
        ({"noise": {"n_tau": 3}}, "config, key noise.n_tau: unknown; "),
        ({"seed": -1}, "config, key seed: -1; expected a whole number >= 0"),
        ({"hampel": {"n_sigma": 0}}, "config, key hampel.n_sigma: 0; expected "),
    ],
)
def test_a_wrong_key_and_a_wrong_value_are_named_with_their_section(config, fault: str) -> None:
    with pytest.raises(Faults) as refused:
        checked(config)
    assert any(line.startswith(fault) for line in refused.value.lines)


def test_limits_of_a_setting_hold_at_both_ends() -> None:
    class Some(Section):
        share: float = Field(0.5, ge=0, le=1)

    assert Some(share=0).share == 0 and Some(share=1).share == 1
    for wrong in (-0.001, 1.001, float("nan")):
        with pytest.raises(ValueError, match="share"):
            Some(share=wrong)
