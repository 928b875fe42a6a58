"""Coordinates: three processors, validity, units, resolution, labels, frame rate."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from make_c3d import build, dec, still

from mocap_metrology.common.errors import Refusal, Unseen
from mocap_metrology.io.c3d.parameters import ieee_from_dec
from mocap_metrology.io.c3d.structure import inspect
from mocap_metrology.io.read import points_by_kind, read_recording

N = 400


def read(path, markers=("M1", "M2"), **keys):
    return read_recording([path], markers, **{"second_opinion": False, **keys})


MM = {"mm": 1, "MM  ": 1, "millimeters": 1, "cm": 10, "m": 1000, "mete": 1000, "Meters": 1000}


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_what_was_stored_is_read(tmp_path, data):
    """In each encoding, with analog samples between, gaps of three kinds, and any unit."""
    draw = data.draw
    processor = draw(st.sampled_from(["Intel", "DEC", "MIPS"]))
    unit, is_float = draw(st.sampled_from([*MM, "", None])), draw(st.booleans())
    n, k, seed = draw(st.integers(2, 60)), draw(st.integers(1, 4)), draw(st.integers(0, 999))
    scale = -0.1 if is_float else draw(st.sampled_from([0.25, 0.0625, 0.1]))
    rng = np.random.default_rng(seed)
    mm = MM[unit] if unit else 1
    if is_float:
        stored = (rng.uniform(30, 900, (n, k, 4)) / mm).astype(np.float32)
        stored[..., 3] = rng.choice([0, 0.5, 15888], (n, k))
    else:
        scale /= mm
        stored = rng.integers(400, 32767, (n, k, 4)) * rng.choice([-1, 1], (n, k, 4))
        stored[..., 3] = rng.choice([0, 0x3E10], (n, k))
    stored[1::5, 0, 1:3] = stored[2::5, 0, :2] = 0  # on an axis
    kind = rng.choice(4, (n, k), p=[0.7, 0.1, 0.1, 0.1])
    kind[0] = 0
    stored[kind == 1, 3] = -1
    stored[kind == 2, :3] = 0
    if is_float and processor != "DEC":  # which has neither
        stored[kind == 3, 1] = rng.choice([np.nan, np.inf, -np.inf])
    else:
        kind[kind == 3] = 0
    analog = None
    if draw(st.booleans()):
        analog = rng.integers(-99, 99, (n, 3)).astype(stored.dtype)
    keys = {"processor": processor, "scale": scale, "units": unit, "analog": analog}
    rate = draw(st.sampled_from([59.94, 100.0, 119.88]))
    path = build(tmp_path / "a.c3d", stored, rate=rate, pad=draw(st.booleans()), **keys)
    order = draw(st.permutations(range(k)))
    recording = read(path, [f"M{i + 1}" for i in order], unit=None if unit else "mm")
    factor = mm * (1.0 if is_float else float(np.float32(scale)))
    expected = np.where(kind[..., None] == 0, stored[..., :3].astype(float) * factor, np.nan)
    position = recording.position_mm
    np.testing.assert_array_equal(position, expected[:, order].transpose(1, 2, 0))
    assert position.dtype == (np.float32 if is_float and factor == 1 else np.float64)
    assert position.flags.c_contiguous and recording.frame_rate_hz == rate
    assert recording.encoding == f"{processor} {'float' if is_float else 'int16'}"
    assert recording.units == ((unit or "mm").strip())
    assert recording.unit_source == ("file" if unit else "given")
    for found, point in zip(recording.n_invalid, order, strict=True):
        counts = [found[reason] for reason in ("negative_residual", "zero", "not_finite")]
        assert counts == np.bincount(kind[:, point], minlength=4)[1:].tolist()
    if not is_float:
        assert recording.resolution_mm == factor and recording.resolution_kind == "int16"
    elif np.isfinite(position).all():
        largest = np.float32(np.abs(stored[..., :3]).max())
        assert recording.resolution_mm == pytest.approx(np.spacing(largest) * mm)


class TestProcessors:
    def test_int16_at_its_limit_is_no_measurement(self, tmp_path):
        """A count saturates at -2^15 and 2^15 - 1 (two's complement): the position is beyond it."""
        steps = np.random.default_rng(2).integers(-100, 100, (N, 2, 4))
        steps[..., 3] = 0
        steps[:40, 0, 0], steps[40:60, 0, 2] = 32767, -32768
        steps[:, 1, 1] = 32766  # one step below
        recording = read(build(tmp_path / "a.c3d", steps, scale=0.25), second_opinion=True)
        lost = np.isnan(recording.position_mm).all(axis=1)
        assert np.flatnonzero(lost[0]).tolist() == list(range(60)) and not lost[1].any()
        assert [n.get("saturated") for n in recording.n_invalid] == [60, None]
        assert [note for note in recording.notes if "saturated" in note] == [
            "a.c3d: M1: 60 frames at the limit of 16-bit integers (saturated), taken as missing"
        ]
        steps[:, 0, 0] = 32767
        with pytest.raises(Unseen):
            read(build(tmp_path / "b.c3d", steps, scale=0.25))

    def test_a_number_for_all_coordinates_that_is_far_off_is_no_measurement(self, tmp_path):
        """As NDI's -3.697e28, on whichever side of the origin; the resolution is that of what was
        measured. Of two files one may have such frames and the other none."""
        for side in (-1, 1):
            frames = side * np.random.default_rng(3).uniform(-10, 900, (N, 2, 4))
            frames[..., 3] = 0
            clean = read(build(tmp_path / "a.c3d", frames))
            frames[5:20, 0, :3] = -3.697314e28
            frames[7, 1, :3] = 500 * side  # alike, not far off
            found = read(build(tmp_path / "b.c3d", frames))
            lost = np.isnan(found.position_mm).all(axis=1)
            assert np.flatnonzero(lost[0]).tolist() == list(range(5, 20)) and not lost[1].any()
            assert [n.get("sentinel") for n in found.n_invalid] == [15, None]
            assert found.resolution_mm == clean.resolution_mm
        assert "b.c3d: M1: x = y = z = -3.697314e+28 in 15 frames, taken as missing" in found.notes
        both = read_recording([tmp_path / "b.c3d", tmp_path / "a.c3d"], ["M1", "M2"])
        assert [n.get("sentinel", 0) for n in both.n_invalid] == [15, 0]

    def test_dec_numbers(self):
        # 1.0 is 0x4080 0000 in F_floating (VAX Architecture Reference Manual): stored 80 40 00 00.
        known = np.frombuffer(bytes.fromhex("80400000 80c00000 49410fdb"), "<u4")
        known = known.copy()
        known[2] = int.from_bytes(bytes.fromhex("4941db0f"), "little")
        assert ieee_from_dec(known).tolist() == [1.0, -1.0, float(np.float32(np.pi))]
        values = np.float32([0, 1e-37, -7.25, 1e30, 4.2e37])
        assert np.array_equal(ieee_from_dec(dec(values)), values)
        largest = np.uint32(0xFFFF7FFF)  # exponent 255, which is a number on a VAX
        assert ieee_from_dec(np.array([largest]))[0] == pytest.approx(2.0**127, rel=1e-6)


class TestValidity:
    def test_reasons(self, tmp_path):
        """Minus decides before zeros; a fourth word that is no number decides nothing."""
        points = still(N)
        points[3] = (0, 0, 0, -1)
        points[4, 0, :3] = (-np.inf, 0, 0)
        points[5, 1] = (0, 0, 0, np.nan)
        points[6:8, 1, 3] = np.nan
        points[8, 1, :3] = (0, 0, 1e-3)
        recording = read(build(tmp_path / "a.c3d", points), second_opinion=True)
        one = {"negative_residual": 1, "zero": 0, "not_finite": 1}
        assert recording.n_invalid == (one, {"negative_residual": 1, "zero": 1, "not_finite": 0})
        assert all(type(n) is int for n in recording.n_invalid[0].values())
        bad = np.isnan(recording.position_mm)
        assert np.flatnonzero(bad[0].all(axis=0)).tolist() == [3, 4]
        assert np.flatnonzero(bad[1].any(axis=0)).tolist() == [3, 5]
        assert recording.notes == ("a.c3d: M2: the fourth word is NaN in 3 frames, taken as valid",)
        assert recording.segments[0].second_opinion == "agrees"


class TestResolution:
    @pytest.mark.parametrize("unit", ["mm", "m"])
    def test_rounded(self, tmp_path, unit):
        factor = {"mm": 1, "m": 1000}[unit]
        for step in (1, 0.5, 0.1, 0.05, 0.01, 0.005, 0.001):
            points = still(N)
            noise = np.random.default_rng(3).normal(0, 3 * step, (N, 2, 3))
            points[..., :3] = step * np.round((points[..., :3] + noise) / step) / factor
            points[:50, 0, 3] = -1
            recording = read(build(tmp_path / "a.c3d", points, units=unit))
            assert (recording.resolution_mm, recording.resolution_kind) == (step, "rounded")

    def test_step_near_the_spacing_is_not_claimed(self, tmp_path):
        points = still(N)
        points[..., :3] = 1e-4 * np.round((points[..., :3] + 1500) / 1e-4)
        assert read(build(tmp_path / "a.c3d", points)).resolution_kind == "float32"


RATES = [  # in the file, as given (Hz), as read or why not
    ({"rate": 59.94}, None, 59.94),  # of a float32 the decimal that was meant
    ({}, 120, 120),
    ({}, 120.12, 120.12),
    ({}, 119.89, 119.89),
    ({}, 120.13, "its frame rate is 120 Hz, 120.13 Hz is stated; they may"),
    ({}, 119.87, "its frame rate is 120 Hz, 119.87 Hz is stated; they may"),
    ({}, 0, "frame_rate_hz is 0, expected a positive number"),
    ({}, -120, "frame_rate_hz is -120, expected a positive number"),
    ({}, float("nan"), "frame_rate_hz is nan, expected a positive number"),
    ({"rate": 0.0}, 200, 200),
    ({"rate": 0.0}, None, "has no frame rate; give it in column frame_rate_hz"),
    ({"point": {"RATE": None}}, None, 120),
    (
        {"rate": 1e-9},
        None,
        "its frame rate, by the file or its times, is 1e-09 Hz; expected at least",
    ),
    ({"rate": 1e-9}, 120, 120),
    ({"rate": 0.0}, 1e9, "frame_rate_hz is 1e+09 Hz; expected at most 1e+06 Hz"),
    ({"point": {"RATE": float("nan")}}, None, 120),
    ({"header_rate": 120.1}, None, 120),
    ({"header_rate": 120.2}, None, "frame rates disagree: 120 Hz by POINT:RATE, 120.2 Hz by the"),
]


@pytest.mark.parametrize(("keys", "given", "expected"), RATES)
def test_frame_rates_may_differ_by_a_tenth_of_a_per_cent(tmp_path, keys, given, expected):
    path = build(tmp_path / "a.c3d", still(N), **keys)
    if isinstance(expected, str):
        with pytest.raises(Refusal) as refused:
            read(path, frame_rate_hz=given)
        assert str(refused.value).startswith(f"a.c3d: {expected}")
    else:
        recording = read(path, frame_rate_hz=given)
        assert recording.frame_rate_hz == expected
        said = [note for note in recording.notes if "in the header" in note]
        assert said == ["a.c3d: frame rate 120 Hz, in the header 120.1 Hz"] * (
            "header_rate" in keys
        )
        said = [
            note for note in recording.notes if "by POINT:RATE is nan Hz, which is none" in note
        ]
        assert len(said) == (keys.get("point", {}).get("RATE") is not None)


def test_labels_go_on_in_further_parameters_and_may_be_missing(tmp_path):
    labels = [f"P{i}" for i in range(299)] + ["Fuß"]
    more = {"LABELS2": labels[255:280], "LABELS3": labels[280:]}
    path = build(tmp_path / "a.c3d", still(3, 303), labels=labels[:255], point=more)
    assert inspect(path).labels == (*labels, "point_301", "point_302", "point_303")
    assert read(path, ["P298", "point_302"]).position_mm.shape == (2, 3, 3)
    none = inspect(build(path, still(3, 2), point={"LABELS": None}))
    assert none.labels == ("point_1", "point_2")


def test_points_that_were_computed_are_no_markers(tmp_path):
    """Those that POINT lists elsewhere, and those whose residual is 0 where others have one."""
    points = still(N, 4)
    points[..., 3] = 0.5
    points[:, 2, 3] = 0
    points[:300, 3, 3] = 0
    keys = {"labels": ["A", "Angle", "Solved", "B"], "point": {"ANGLES": ["Angle"]}}
    path = build(tmp_path / "a.c3d", points, processor="DEC", **keys)
    assert points_by_kind(path) == {"marker": ("A", "B"), "computed": ("Angle", "Solved")}
    points[..., 3] = 0
    path = build(tmp_path / "a.c3d", points, **keys)
    assert points_by_kind(path) == {"marker": ("A", "Solved", "B"), "computed": ("Angle",)}
