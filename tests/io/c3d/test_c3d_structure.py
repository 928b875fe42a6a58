"""What is not a C3D file, or a damaged one, is refused in one line; nothing hangs or crashes."""

import os

import numpy as np
import pytest
from make_c3d import build, record, still

from mocap_metrology.common.errors import Refusal, Truncated
from mocap_metrology.io.c3d.structure import inspect
from mocap_metrology.io.read import read_recording


@pytest.mark.parametrize(
    ("content", "looks"),
    [
        (b"Frame\tTime\tX1\tY1\n" * 100, "text"),
        ("Größe;1\n".encode("latin-1") * 100, "text"),
        (bytes(4096), "zeros only"),
        (np.random.default_rng(1).bytes(4096), "another binary format"),
        (b"\x02", "another binary format"),
    ],
)
def test_not_a_c3d_file(tmp_path, content, looks):
    (tmp_path / "a.c3d").write_bytes(content)
    with pytest.raises(Refusal, match=rf"^a\.c3d: is not a C3D file: it looks like {looks}"):
        inspect(tmp_path / "a.c3d")


def test_not_a_file(tmp_path):
    (tmp_path / "empty.c3d").touch()
    (tmp_path / "folder.c3d").mkdir()
    os.mkfifo(tmp_path / "pipe.c3d")
    for name, message in (
        ("empty.c3d", "is empty"),
        ("folder.c3d", "is a folder"),
        ("pipe.c3d", "is a device or a pipe"),
        ("missing.c3d", "no such file"),
        ("nul\0.c3d", "not a file name"),
        ("empty.c3d/a.c3d", "cannot be read: Not a directory"),
    ):
        with pytest.raises(Refusal) as refusal:
            inspect(tmp_path / name)
        assert str(refusal.value).split(": ", 1)[1].startswith(message), name
    with pytest.raises(Refusal, match=r"^null: is a device"):
        inspect("/dev/null")


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"point": {"USED": 3}}, "2 points by the header, 3 by POINT:USED"),
        ({"point": {"USED": None}}, "has no POINT:USED"),
        ({"data_start": 7}, "data at block 3 by the header, 7 by POINT:DATA_START"),
        ({"scale": 0.1, "header_scale": 0.2}, "scale 0.2 by the header, 0.1 by POINT:SCALE"),
        ({"header_scale": 0.1}, "scale 0.1 by the header, -0.1 by POINT:SCALE"),
        ({"point": {"SCALE": 0.0}}, "POINT:SCALE is 0, expected"),
        ({"point": {"X": b"\xff\x07" + b"\xff" * 7}}, "values of 'X' reach"),
        ({"point": {"X": b"\x02\x01\x05"}}, "values of 'X' reach 9 bytes past"),
        ({"point": {"X": b"\x02\x08" + b"\x01" * 8}}, "type 2 and 8 dimensions"),
        ({"point": {"X": b"\x03\x00"}}, "type 3 and 0 dimensions"),
        ({"point": {"X": b""}}, "parameter 'X' has"),
    ],
)
def test_contradictions(tmp_path, keys, message):
    with pytest.raises(Refusal) as refusal:
        inspect(build(tmp_path / "a.c3d", still(50), **keys))
    assert str(refusal.value).startswith("a.c3d: ") and message in str(refusal.value)


RATE = record("RATE", 1, b"\x04\x00" + np.float32(120).tobytes(), "Intel")
ANALOG = record("ANALOG", -2, b"", "Intel")
LONGER = {"point": {"DATA_START": None, "X": "x" * 200, "Y": "y" * 200, "Z": "z" * 200}}
PATCHES = [  # what stands at a place, or there is once, and is replaced
    (0, b"\0", "damaged: the parameters should be at block 0, the file has 6 blocks of 512 bytes"),
    (0, b"\xff", "damaged: the parameters should be at block 255, the file has 6 blocks"),
    (515, b"\x53", "damaged: processor 83, expected 84 (Intel), 85 (DEC), 86 (MIPS)"),
    (516, b"\0", "has no parameters, expected at least POINT:USED and POINT:LABELS"),
    (517, b"\0", "damaged: parameter 'POINT' belongs to group 0"),
    (523, b"\xff\xff", "damaged: parameter record 'POINT' reaches past its section"),
    (523, b"\x01\x00", "damaged: parameter record 'POINT' reaches past its section"),
    (16, b"\xff\xff", "damaged: data at block 65535 by the header, 3 by POINT:DATA_START"),
    (RATE, RATE[:-1] + b"\x01", "damaged: description of 'RATE' reaches past its record"),
    (RATE, RATE.replace(b"RATE", b"USED"), "damaged: parameter 'USED' stands twice in one group"),
    (ANALOG, record("ANALOG", -1, b"", "Intel"),
     "damaged: the groups 'POINT' and 'ANALOG' have the number 1"),
    (ANALOG, record("POINT ", -2, b"", "Intel"),
     "damaged: 2 groups are named 'POINT'; expected one"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), PATCHES)
def test_a_patched_file(tmp_path, old, new, message):
    path = build(tmp_path / "a.c3d", still(50))
    raw = path.read_bytes()
    if isinstance(old, bytes):
        assert raw.count(old) == 1
        path.write_bytes(raw.replace(old, new))
    else:
        path.write_bytes(raw[:old] + new + raw[old + len(new) :])
    with pytest.raises(Refusal) as refusal:
        inspect(path)
    assert str(refusal.value).startswith(f"a.c3d: {message}")


def test_where_the_parameters_end(tmp_path):
    """They may be declared up into the data, unless only the header says where these begin."""
    raw = bytearray(build(tmp_path / "a.c3d", still(50)).read_bytes())
    raw[514] = 0x30
    (tmp_path / "a.c3d").write_bytes(raw)
    said = "the parameter section is declared longer than up to the data"
    assert inspect(tmp_path / "a.c3d").notes == (said,)
    raw = bytearray(build(tmp_path / "a.c3d", still(48), **LONGER).read_bytes())
    assert raw[16] == 4 and raw[514] == 2
    raw[16] = 3
    (tmp_path / "a.c3d").write_bytes(raw)
    with pytest.raises(Refusal, match=r"damaged: (data at block 3 by the header|parameter record)"):
        inspect(tmp_path / "a.c3d")


@pytest.mark.parametrize("pad", [True, False])
def test_line_ends_that_a_transfer_as_text_changed(tmp_path, pad):
    """Of CR LF in n places LF is left, or the other way round."""
    path = build(tmp_path / "a.c3d", still(50), pad=pad)
    raw = path.read_bytes()
    for n in (1, 2, 5):
        lossy = bytearray(raw)
        for k in range(n):
            lossy[1536 + 32 * k + 1 : 1536 + 32 * k + 3] = b"\r\n"
        path.write_bytes(bytes(lossy).replace(b"\r\n", b"\n"))
        with pytest.raises(Truncated, match=r"^a\.c3d: (damaged: it ends \d+ bytes into a bl|cut)"):
            inspect(path)
    assert b"\n" in raw
    path.write_bytes(raw.replace(b"\n", b"\r\n"))
    with pytest.raises(Refusal):
        inspect(path)


def test_padding_that_is_cut_off_and_padding_that_is_no_frame(tmp_path):
    path = build(tmp_path / "a.c3d", still(50))  # 1600 bytes of data and 448 of padding
    raw = path.read_bytes()
    for cut in (1, 100, 383):
        path.write_bytes(raw[:-cut])
        with pytest.raises(Truncated, match=r"damaged: it ends .* as by a transfer as text"):
            inspect(path)
        structure = inspect(path, accept_truncated=True)
        assert structure.n_frames == 50 and "used as it is" in structure.notes[0]
    path = build(tmp_path / "a.c3d", still(50), frames=500, header=(1, 500))
    with pytest.raises(Truncated, match=r"cut off: .* frames in the file: 50$"):
        inspect(path)
    assert inspect(path, accept_truncated=True).n_frames == 50


@pytest.mark.parametrize("size", [2, 100, 511, 512, 514, 520, 600, 1000, 1500])
def test_cut_before_the_data(tmp_path, size):
    path = build(tmp_path / "a.c3d", still(50))
    path.write_bytes(path.read_bytes()[:size])
    with pytest.raises(Refusal, match=r"^a\.c3d: (cut off|damaged)"):
        inspect(path)


def test_a_unit_that_is_lost(tmp_path):
    """Bits of the name of UNITS: 504 mm must not become 0.504 mm."""
    path = build(tmp_path / "a.c3d", still(50) / np.float32(1000), units="m")
    raw = bytearray(path.read_bytes())
    at = raw.index(b"UNITS") - 2
    refused = 0
    for bit in range(8 * 10):
        mutant = raw.copy()
        mutant[at + bit // 8] ^= 1 << bit % 8
        path.write_bytes(mutant)
        try:
            recording = read_recording([path], ["M1", "M2"], second_opinion=False)
        except Refusal:
            refused += 1
        else:
            assert (recording.units.lower(), recording.unit_source) == ("m", "file")
    assert refused > 40


def test_a_file_that_ezc3d_cannot_read_alone(tmp_path):
    steps = np.random.default_rng(1).integers(-900, 900, (50, 2, 4)) * [1, 1, 1, 0]
    for name in ("SCALE", "FRAMES"):
        path = build(tmp_path / "a.c3d", steps, scale=0.1, point={name: None})
        recording = read_recording([path], ["M1"])
        lack = f"the file has no POINT:{name}, which ezc3d needs"
        assert recording.segments[0].second_opinion == f"not asked ({lack})"
        assert recording.notes == (f"a.c3d: no second opinion: {lack}",)
