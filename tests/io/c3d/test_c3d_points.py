"""Coordinates: three processors, validity, units, resolution, labels, frame rate."""

from __future__ import annotations

import numpy as np
import pytest
from make_c3d import build, dec, still

from mocap_metrology.common.errors import Refusal, Unseen
from mocap_metrology.io.c3d.parameters import ieee_from_dec
from mocap_metrology.io.c3d.structure import inspect
from mocap_metrology.io.read import read_recording

N = 400


def read(path, markers=("M1", "M2"), **keys):
    return read_recording([path], markers, **{"second_opinion": False, **keys})


class TestProcessors:
    @pytest.mark.parametrize("processor", ["Intel", "DEC", "MIPS"])
    def test_float(self, tmp_path, processor):
        points = still(N)
        recording = read(build(tmp_path / "a.c3d", points, processor=processor))
        assert np.array_equal(recording.position_mm, points[..., :3].transpose(1, 2, 0))
        assert recording.encoding == f"{processor} float"
        assert recording.position_mm.dtype == np.float32
        assert recording.position_mm.flags.c_contiguous

    @pytest.mark.parametrize("processor", ["Intel", "DEC", "MIPS"])
    def test_int16(self, tmp_path, processor):
        steps = np.random.default_rng(1).integers(-32768, 32768, (N, 2, 4))
        steps[..., 3] = 0x3E10  # camera mask and residual
        steps[5, 0, 3] = steps[6, 1, 3] = -1
        steps[7, 1, 3] = -32768
        path = build(tmp_path / "a.c3d", steps, processor=processor, scale=0.25)
        recording = read(path, second_opinion=True)
        expected = 0.25 * steps[..., :3].transpose(1, 2, 0)
        expected[0, :, 5] = expected[1, :, 6] = expected[1, :, 7] = np.nan
        assert np.array_equal(recording.position_mm, expected, equal_nan=True)
        assert [n["negative_residual"] for n in recording.n_invalid] == [1, 2]
        assert (recording.resolution_mm, recording.resolution_kind) == (0.25, "int16")
        wanted = "agrees" if processor != "MIPS" else "not asked (ezc3d does not read MIPS files)"
        assert recording.segments[0].second_opinion == wanted

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
        points = still(N)
        points[3, 0, 3] = -1
        points[4, 0, 3] = -2.5
        points[5:8, 0, :3] = 0
        points[8, 0] = (0, 0, 0, -1)
        points[9, 0, 1] = np.nan
        points[10, 0, 2] = np.inf
        points[11, 0, :3] = (-np.inf, 0, 0)
        points[12:14, 1, 3] = np.nan
        points[14, 1] = (0, 0, 0, np.nan)
        points[15, 1, :3] = (0, 0, 1e-3)
        points[16, 1, 3] = 15888
        recording = read(build(tmp_path / "a.c3d", points), second_opinion=True)
        first = {"negative_residual": 3, "zero": 3, "not_finite": 3}
        assert recording.n_invalid == (first, {"negative_residual": 0, "zero": 1, "not_finite": 0})
        assert all(type(n) is int for n in recording.n_invalid[0].values())
        bad = np.isnan(recording.position_mm)
        assert np.flatnonzero(bad[0].all(axis=0)).tolist() == list(range(3, 12))
        assert np.flatnonzero(bad[1].any(axis=0)).tolist() == [14]
        assert recording.notes == ("a.c3d: M2: the fourth word is NaN in 3 frames, taken as valid",)
        assert recording.segments[0].second_opinion == "agrees"

    def test_never_seen(self, tmp_path):
        points = still(N)
        points[:300, 1, 3] = -1
        points[300:, 1, :3] = 0
        path = build(tmp_path / "a.c3d", points)
        assert read(path, ["M1"]).n_invalid[0]["zero"] == 0
        with pytest.raises(Unseen, match=r"'M2'.* of 400 .*300 .*100 zero"):
            read(path)

    def test_one_frame(self, tmp_path):
        with pytest.raises(Refusal, match=r"^a\.c3d: has 1 frame, expected at least 2 frames$"):
            read(build(tmp_path / "a.c3d", still(1)))


class TestUnits:
    @pytest.mark.parametrize(
        ("units", "factor"),
        [
            ("mm", 1),
            ("MM  ", 1),
            ("m", 1000),
            ("mete", 1000),
            ("Meters", 1000),
            ("metre", 1000),
            ("cm", 10),
            ("millimeters", 1),
            (["cm", "cm  "], 10),
        ],
    )
    def test_known(self, tmp_path, units, factor):
        points = still(N) / np.float32(factor)
        recording = read(build(tmp_path / "a.c3d", points, units=units), second_opinion=True)
        expected = points[..., :3].transpose(1, 2, 0).astype(float) * factor
        assert np.array_equal(recording.position_mm, expected)
        assert recording.position_mm.dtype == (np.float32 if factor == 1 else np.float64)
        assert recording.segments[0].second_opinion == "agrees"

    def test_int16_in_metres(self, tmp_path):
        steps = np.random.default_rng(1).integers(-3000, 3000, (N, 2, 4)) * [1, 1, 1, 0]
        recording = read(build(tmp_path / "a.c3d", steps, scale=0.0005, units="m"))
        assert recording.resolution_mm == pytest.approx(0.5)
        expected = 0.5 * steps[..., :3].transpose(1, 2, 0)
        assert np.allclose(recording.position_mm, expected, rtol=1e-6, atol=0)

    @pytest.mark.parametrize("units", ["in", "furlong", "deg"])
    def test_unknown(self, tmp_path, units):
        with pytest.raises(Refusal, match=rf"^a\.c3d: POINT:UNITS is '{units}', expected one"):
            inspect(build(tmp_path / "a.c3d", still(N), units=units))

    def test_they_differ(self, tmp_path):
        with pytest.raises(Refusal, match=r"differ between points \(m, mm\)"):
            inspect(build(tmp_path / "a.c3d", still(N), units=["mm", "m"]))

    @pytest.mark.parametrize("units", [None, "", "    "])
    def test_missing(self, tmp_path, units):
        recording = read(build(tmp_path / "a.c3d", still(N), units=units))
        assert (recording.units, recording.unit_source) == ("mm", "assumed")
        assert "a.c3d: no unit in POINT:UNITS: mm is assumed" in recording.notes


class TestResolution:
    def test_float32(self, tmp_path):
        points = still(N)
        points[..., :3] = np.random.default_rng(1).uniform(-900, 900, (N, 2, 3))
        points[:, 1, 2] = np.random.default_rng(2).uniform(1025, 2000, N)
        recording = read(build(tmp_path / "a.c3d", points))
        assert (recording.resolution_mm, recording.resolution_kind) == (2.0**-13, "float32")
        assert read(tmp_path / "a.c3d", ["M1"]).resolution_mm == 2.0**-14

    def test_float32_in_metres(self, tmp_path):
        points = np.random.default_rng(1).uniform(1, 2, (N, 2, 4)).astype("f4") * [-1, 1, 1, 0]
        recording = read(build(tmp_path / "a.c3d", points.astype("f4"), units="m"))
        assert recording.resolution_mm == pytest.approx(1000 * 2.0**-23)

    @pytest.mark.parametrize("unit", ["mm", "m"])
    @pytest.mark.parametrize("step", [1, 0.5, 0.1, 0.05, 0.01, 0.005, 0.001])
    def test_rounded(self, tmp_path, step, unit):
        factor = {"mm": 1, "m": 1000}[unit]
        points = still(N)
        noise = np.random.default_rng(3).normal(0, 3 * step, (N, 2, 3))
        rounded = step * np.round((points[..., :3] + noise) / step)
        points[..., :3] = rounded / factor
        points[:50, 0, 3] = -1
        recording = read(build(tmp_path / "a.c3d", points, units=unit))
        assert (recording.resolution_mm, recording.resolution_kind) == (step, "rounded")

    def test_integers_rewritten_as_floats(self, samples):
        """Codamotion, steps of 0.1 mm, exported once as int16 and once as float."""
        folder = samples / "c3d" / "btk_others"
        for name, kind in (("integer", "int16"), ("float", "rounded")):
            path = folder / f"ADemo1_rewrite_c3d_pc_{name}.c3d"
            recording = read(path, inspect(path).labels)
            assert recording.resolution_mm == pytest.approx(0.1)
            assert recording.resolution_kind == kind

    def test_step_near_the_spacing_is_not_claimed(self, tmp_path):
        points = still(N)
        points[..., :3] = 1e-4 * np.round((points[..., :3] + 1500) / 1e-4)
        assert read(build(tmp_path / "a.c3d", points)).resolution_kind == "float32"

    def test_constant(self, tmp_path):
        points = np.ones((N, 2, 4), "f4") * [100, 200, 300, 0]
        recording = read(build(tmp_path / "a.c3d", points.astype("f4")))
        assert recording.resolution_kind == "float32"

    def test_one_coordinate_alone_is_rounded(self, tmp_path):
        points = still(N)
        points[:, 0, 0] = np.round(points[:, 0, 0])
        assert read(build(tmp_path / "a.c3d", points)).resolution_kind == "float32"


class TestLabels:
    def test_as_asked_for(self, tmp_path):
        points = still(N, 4)
        path = build(tmp_path / "a.c3d", points, labels=["Wand:A", "Wand:B", "Cal:B", "C D"])
        recording = read(path, ["A", " C D ", "Cal:B"])
        assert recording.labels == ("A", "C D", "Cal:B")
        assert np.array_equal(recording.position_mm, points[:, [0, 3, 2], :3].transpose(1, 2, 0))
        with pytest.raises(Refusal, match="'B' occurs several times: choose from Wand:B, Cal:B"):
            read(path, ["B"])
        with pytest.raises(Refusal, match="'Wand:A' is chosen twice"):
            read(path, ["A", "Wand:A"])
        with pytest.raises(Refusal, match=r"^a\.c3d: .*'E'.*Wand:A, Wand:B"):
            read(path, ["A", "E"])
        with pytest.raises(Refusal, match="no marker is chosen"):
            read(path, [])

    def test_twice(self, tmp_path):
        points = still(N, 3)
        path = build(tmp_path / "a.c3d", points, labels=["A", "B", "A"])
        recording = read(path, ["A#2", "A#1"])
        assert np.array_equal(recording.position_mm, points[:, [2, 0], :3].transpose(1, 2, 0))
        assert recording.labels == ("A#2", "A#1")

    def test_continued_and_missing(self, tmp_path):
        labels = [f"P{i}" for i in range(300)]
        more = {"LABELS2": labels[255:280], "LABELS3": labels[280:]}
        path = build(tmp_path / "a.c3d", still(3, 303), labels=labels[:255], point=more)
        structure = inspect(path)
        assert structure.labels == (*labels, "point_301", "point_302", "point_303")
        assert read(path, ["P299", "point_302"]).position_mm.shape == (2, 3, 3)
        none = inspect(build(path, still(3, 2), point={"LABELS": None}))
        assert none.labels == ("point_1", "point_2")

    def test_not_ascii(self, tmp_path):
        path = build(tmp_path / "a.c3d", still(N), labels=["Fuß", "Knie"])
        assert read(path, ["Fuß"], second_opinion=True).labels == ("Fuß",)


class TestFrameRate:
    def test_float32_is_read_as_the_decimal_meant(self, tmp_path):
        path = build(tmp_path / "a.c3d", still(N), rate=59.94)
        assert read(path).frame_rate_hz == 59.94

    @pytest.mark.parametrize("given", [120, 120.05, 119.9])
    def test_given(self, tmp_path, given):
        path = build(tmp_path / "a.c3d", still(N))
        assert read(path, frame_rate_hz=given).frame_rate_hz == given

    @pytest.mark.parametrize("given", [100, 120.2, 60])
    def test_given_differs(self, tmp_path, given):
        path = build(tmp_path / "a.c3d", still(N))
        with pytest.raises(Refusal, match=f"is 120 Hz, column frame_rate_hz states {given}"):
            read(path, frame_rate_hz=given)

    @pytest.mark.parametrize("given", [0, -120, float("nan")])
    def test_given_is_nonsense(self, tmp_path, given):
        with pytest.raises(Refusal, match="expected a positive number"):
            read(build(tmp_path / "a.c3d", still(N)), frame_rate_hz=given)

    def test_absent(self, tmp_path):
        path = build(tmp_path / "a.c3d", still(N), rate=0.0)
        assert inspect(path).frame_rate_hz == 0
        assert read(path, frame_rate_hz=200).frame_rate_hz == 200
        with pytest.raises(Refusal, match=r"^a\.c3d: .*frame_rate_hz"):
            read(path)

    def test_header_alone(self, tmp_path):
        path = build(tmp_path / "a.c3d", still(N), point={"RATE": None})
        assert inspect(path).frame_rate_hz == 120

    def test_header_differs_a_little(self, tmp_path):
        structure = inspect(build(tmp_path / "a.c3d", still(N), header_rate=120.05))
        assert structure.frame_rate_hz == 120
        assert structure.notes == ("frame rate 120 Hz, in the header 120.05 Hz",)

    def test_header_differs(self, tmp_path):
        with pytest.raises(Refusal, match="120 Hz by POINT:RATE, 100 Hz by the header"):
            inspect(build(tmp_path / "a.c3d", still(N), header_rate=100))
