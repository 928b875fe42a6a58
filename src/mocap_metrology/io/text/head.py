"""The first lines of a text file: told from other kinds of files, decoded, and where they end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.recognise import SIGNATURES, regular_size

LONGEST_LINE = 1 << 20  # bytes; 30,000 markers
BOM = b"\xef\xbb\xbf"


@dataclass(frozen=True)
class Line:
    """One line without its end; `number` from 1; `start` and `end` in bytes, its end included."""

    text: str
    number: int
    start: int
    end: int

    def cells(self, delimiter: str) -> list[str]:
        """Its cells, stripped; the spaces round a number mean nothing. A delimiter of one space
        stands for any run of spaces and tabs, at either end too."""
        if delimiter == " ":
            return self.text.split()
        return [cell.strip() for cell in self.text.split(delimiter)]


def lines(path: Path, start: int = 0, number: int = 1) -> Iterator[Line]:
    """Lines from byte `start` on, the first being line `number`; UTF-8, else Latin-1."""
    with path.open("rb") as stream:
        stream.seek(start)
        while raw := stream.readline(LONGEST_LINE):
            if len(raw) == LONGEST_LINE:
                raise Refusal(f"{path.name}: line {number} is longer than {LONGEST_LINE} bytes")
            end = start + len(raw)
            body = raw.removeprefix(BOM) if start == 0 else raw
            yield Line(decoded(body).rstrip("\r\n"), number, start, end)
            start, number = end, number + 1


def decoded(raw: bytes) -> str:
    """UTF-8 where it is, else Latin-1, in which every byte is a letter."""
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def check_text(path: Path, expected: str) -> None:
    """Refuse what is no text file: nothing, a folder, another format, another encoding."""
    size = regular_size(path, expected)
    with path.open("rb") as stream:
        block = stream.read(4096)
    looks = next((what for start, what in SIGNATURES if block.startswith(start)), None)
    if block[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise Refusal(f"{path.name}: is UTF-16 text, expected UTF-8: save it as UTF-8")
    if looks is None and block[1:2] == b"\x50" and b"\0" in block:
        looks = "a C3D file"
    if looks is None and any(byte < 32 and byte not in b"\t\r\n\f" for byte in block):
        looks = "a binary format"
    if looks is not None:
        raise Refusal(f"{path.name}: is not {expected}: it looks like {looks}")
    if not block.removeprefix(BOM).strip() and size <= 4096:
        raise Refusal(f"{path.name}: holds nothing but white space, expected {expected}")
    if b"\r" in block and b"\n" not in block and len(block.split(b"\r")) > 2:
        raise Refusal(f"{path.name}: its lines end with CR alone, expected LF or CR LF")
