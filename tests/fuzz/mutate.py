"""Damage to files, from a random generator: what disks, transfers, editors and typing do."""

import numpy as np

Rng = np.random.Generator

NUMBERS = (b"1e999", b"-1", b"nan", b"inf", b"", b"0", b"1e12", b"1,5", b"0x10", b"9" * 400)
NUMBERS += (b"NA", b"None", b'"1.5"', b'"1.5', b'"1,5"', b"-nan", b"#REF!")
JUNK = ("\0", "\x1b[2J", "\ufeff", "\u202e", "\u0663", "=1+1", "<b>")
JUNK += ('"', ";", "\t", ",", " ", "\r", "[", "{")


def binary(content: bytes, rng: Rng, front: int) -> tuple[bytes, str]:
    """A damaged copy, and what was done; seven of ten times within the first `front` bytes."""
    out = bytearray(content)
    end = max(1, min(front if rng.random() < 0.7 else len(out), len(out)))
    damage = BINARY[int(rng.choice(len(BINARY), p=SHARES))]
    damage(out, rng, end)
    return bytes(out), damage.__name__.strip("_")


def _bit(out: bytearray, rng: Rng, end: int) -> None:
    out[int(rng.integers(end))] ^= 1 << int(rng.integers(8))


def _bits(out: bytearray, rng: Rng, end: int) -> None:
    for _ in range(int(rng.integers(2, 6))):
        _bit(out, rng, end)


def _byte(out: bytearray, rng: Rng, end: int) -> None:
    out[int(rng.integers(end))] = int(rng.choice([0, 1, 127, 128, 255, int(rng.integers(256))]))


def _block(out: bytearray, rng: Rng, end: int) -> None:
    """A sector lost, or filled with something else."""
    start, n = int(rng.integers(end)), int(rng.choice([1, 4, 16, 64, 512]))
    n = min(n, len(out) - start)
    out[start : start + n] = bytes(n) if rng.random() < 0.5 else rng.bytes(n)


def _cut(out: bytearray, rng: Rng, end: int) -> None:
    del out[int(rng.integers(end)) :]


def _lost(out: bytearray, rng: Rng, end: int) -> None:
    start = int(rng.integers(end))
    del out[start : start + int(rng.choice([1, 2, 4, 16, 512]))]


def _added(out: bytearray, rng: Rng, end: int) -> None:
    start = int(rng.integers(end))
    out[start:start] = rng.bytes(int(rng.choice([1, 2, 4, 16, 512])))


def _doubled(out: bytearray, rng: Rng, end: int) -> None:
    start, n = int(rng.integers(end)), int(rng.choice([4, 32, 512]))
    out[start:start] = out[start : start + n]


def _moved(out: bytearray, rng: Rng, end: int) -> None:
    """Two sectors exchanged."""
    n = 512
    a, b = (int(v) * n for v in rng.integers(0, max(1, len(out) // n), 2))
    if len(out[a : a + n]) == len(out[b : b + n]):
        out[a : a + n], out[b : b + n] = out[b : b + n], out[a : a + n]


def _as_text(out: bytearray, rng: Rng, end: int) -> None:
    """A transfer that changes line ends, or takes out zeros."""
    if rng.random() < 0.5:  # make sure that there is something to change
        at = int(rng.integers(max(1, len(out) - 2)))
        out[at : at + 2] = b"\r\n"
    ways = ((b"\r\n", b"\n"), (b"\n", b"\r\n"), (b"\0", b""), (b"\r", b""), (b"\x1a", b""))
    old, new = ways[int(rng.integers(len(ways)))]
    out[:] = out.replace(old, new)


def _small_word(out: bytearray, rng: Rng, end: int) -> None:
    """A 16-bit count one or two off."""
    at = int(rng.integers(end)) & ~1
    word = int.from_bytes(out[at : at + 2], "little") + int(rng.choice([-2, -1, 1, 2]))
    out[at : at + 2] = (word % 65536).to_bytes(2, "little")


def c3d(content: bytes, rng: Rng, front: int) -> tuple[bytes, str]:
    """A damaged C3D file: in two of five cases its structure contradicts itself."""
    if rng.random() < 0.6:
        return binary(content, rng, front)
    out = bytearray(content)
    damage = STRUCTURE[int(rng.integers(len(STRUCTURE)))]
    damage(out, rng)
    return bytes(out), damage.__name__.strip("_")


def _header_word(out: bytearray, rng: Rng) -> None:
    """Points, analog values, first and last frame, scale, start of the data, rate of the header."""
    at = 2 * int(rng.choice([1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]))
    other = (bytes(2), b"\x01\x00", b"\xff\xff", rng.bytes(2), bytes([out[at] ^ 1, out[at + 1]]))
    out[at : at + 2] = other[int(rng.integers(len(other)))]


def _records(section: bytes, order: str) -> dict[tuple[int, str], bytes]:
    """Records of the parameter section by group number (negative of a group) and name."""
    found, at = {}, 4
    while at + 2 < len(section) and section[at]:
        length, number = (int(v) for v in np.frombuffer(section[at : at + 2], np.int8))
        pointer = at + 2 + abs(length)
        after = pointer + int.from_bytes(section[pointer : pointer + 2], order)
        found[number, section[at + 2 : pointer].decode("latin-1")] = section[at:after]
        if after <= pointer:
            break
        at = after
    return found


def _inserted(out: bytearray, rng: Rng, group: bool) -> None:
    """A parameter of POINT a second time, with other values: beside the first, or in a second group
    of the same name. The padding of the section makes room."""
    start = (out[0] - 1) * 512
    stop = start + 512 * out[start + 2]
    order = "big" if out[start + 3] == 86 else "little"
    records = _records(bytes(out[start:stop]), order)
    number, point = next((k, v) for (k, name), v in records.items() if k < 0 and name == "POINT")
    own = [v for (k, _), v in records.items() if k == -number]
    copy = bytearray(own[int(rng.integers(len(own)))])
    name = min(copy[0], 256 - copy[0])  # its length, negative where the record is locked
    place = 2 + name + 4 + copy[2 + name + 3]  # of the first value
    copy[min(place + int(rng.integers(4)), len(copy) - 2)] ^= 1 << int(rng.integers(7))
    new = bytes(copy)
    if group:
        other = min(k for k, _ in records) - 1
        copy[1] = -other
        new = point[:1] + bytes([other % 256]) + point[2:] + bytes(copy)
    if not any(out[stop - len(new) : stop]):
        del out[stop - len(new) : stop]
        out[start + 4 : start + 4] = new


def _second_group(out: bytearray, rng: Rng) -> None:
    _inserted(out, rng, True)


def _second_parameter(out: bytearray, rng: Rng) -> None:
    _inserted(out, rng, False)


STRUCTURE = (_header_word, _second_group, _second_parameter)
BINARY = (_bit, _bits, _byte, _block, _cut, _lost, _added, _doubled, _moved, _as_text, _small_word)
SHARES = np.array([30, 8, 14, 8, 8, 5, 5, 3, 3, 8, 8]) / 100


def text(content: bytes, rng: Rng) -> tuple[bytes, str]:
    """A damaged copy of a text, and what was done."""
    if rng.random() < 0.25:
        return binary(content, rng, len(content))
    lines = content.split(b"\n")
    k = int(rng.integers(len(lines)))
    if rng.random() < 0.4:
        k = min(k, int(rng.integers(16)))
    damage = TEXT[int(rng.integers(len(TEXT)))]
    damage(lines, k, rng)
    return b"\n".join(lines), damage.__name__.strip("_")


def _cells(line: bytes) -> tuple[list[bytes], bytes]:
    mark = max(b"\t;, ", key=lambda m: line.count(bytes([m])))
    return line.split(bytes([mark])), bytes([mark])


def _digit(lines: list[bytes], k: int, rng: Rng) -> None:
    at = [i for i, c in enumerate(lines[k]) if 48 <= c <= 57]
    if at:
        line = bytearray(lines[k])
        line[at[int(rng.integers(len(at)))]] = 48 + int(rng.integers(10))
        lines[k] = bytes(line)


def _number(lines: list[bytes], k: int, rng: Rng) -> None:
    cells, mark = _cells(lines[k])
    cells[int(rng.integers(len(cells)))] = NUMBERS[int(rng.integers(len(NUMBERS)))]
    lines[k] = mark.join(cells)


def _cell_lost(lines: list[bytes], k: int, rng: Rng) -> None:
    cells, mark = _cells(lines[k])
    del cells[int(rng.integers(len(cells)))]
    lines[k] = mark.join(cells)


def _cells_swapped(lines: list[bytes], k: int, rng: Rng) -> None:
    cells, mark = _cells(lines[k])
    a, b = (int(v) for v in rng.integers(0, len(cells), 2))
    cells[a], cells[b] = cells[b], cells[a]
    lines[k] = mark.join(cells)


def _junk(lines: list[bytes], k: int, rng: Rng) -> None:
    at = int(rng.integers(len(lines[k]) + 1))
    letters = JUNK[int(rng.integers(len(JUNK)))].encode() * int(rng.choice([1, 1, 1, 2, 50_000]))
    lines[k] = lines[k][:at] + letters + lines[k][at:]


def _line_lost(lines: list[bytes], k: int, rng: Rng) -> None:
    del lines[k]


def _line_doubled(lines: list[bytes], k: int, rng: Rng) -> None:
    lines.insert(k, lines[k])


def _lines_swapped(lines: list[bytes], k: int, rng: Rng) -> None:
    other = int(rng.integers(len(lines)))
    lines[k], lines[other] = lines[other], lines[k]


def _line_cut(lines: list[bytes], k: int, rng: Rng) -> None:
    lines[k] = lines[k][: int(rng.integers(len(lines[k]) + 1))]


def _cut_here(lines: list[bytes], k: int, rng: Rng) -> None:
    del lines[k + 1 :]
    _line_cut(lines, k, rng)


def _joined(lines: list[bytes], k: int, rng: Rng) -> None:
    lines[k : k + 2] = [b"".join(lines[k : k + 2])]


def _letter_case(lines: list[bytes], k: int, rng: Rng) -> None:
    lines[k] = lines[k].swapcase()


def _blanks(lines: list[bytes], k: int, rng: Rng) -> None:
    """No meaning: blanks at the end of a line, line ends of Windows."""
    for i in range(len(lines)):
        lines[i] = lines[i].rstrip(b"\r") + (b"" if i == len(lines) - 1 else b"\r")


def _column(lines: list[bytes], k: int, rng: Rng) -> None:
    """Frame numbers or times (one of the first two columns of numbers): all zero, all equal, in
    reverse order, or not numbers."""
    rows = [i for i, line in enumerate(lines) if len(_cells(line)[0]) > 5]
    rows = [i for i in rows if lines[i][:1].isdigit() and _cells(lines[i])[1] != b" "]
    column, way = int(rng.integers(2)), int(rng.integers(4))
    cells = [_cells(lines[i]) for i in rows]
    values = [row[column] for row, _ in cells]
    made = ([b"0"] * len(rows), values[:1] * len(rows), values[::-1], [b"nan"] * len(rows))[way]
    for i, (row, mark), value in zip(rows, cells, made, strict=True):
        lines[i] = mark.join([*row[:column], value, *row[column + 1 :]])


TEXT = (_column, _digit, _number, _cell_lost, _cells_swapped, _junk, _line_lost, _line_doubled,
        _lines_swapped, _line_cut, _cut_here, _joined, _letter_case, _blanks)  # fmt: skip
