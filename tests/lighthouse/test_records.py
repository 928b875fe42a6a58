"""What is stored of a calibration that cannot be."""

from mocap_metrology.lighthouse.assess.summary import refused
from mocap_metrology.lighthouse.records import Station


def test_a_calibration_that_cannot_be_has_no_pose_and_a_reason() -> None:
    made = refused([Station("master", 11), Station("slave", 12)], "sweeps on 3 diodes")
    assert made.document["poses"] == [] and made.document["chosen"] is None
    assert (made.verdict.word, made.verdict.why_none) == ("failed", "sweeps on 3 diodes")
    assert made.document["stations"]["slave"]["id"] == 12
