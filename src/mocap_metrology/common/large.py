"""Arrays by name that need not fit into memory together: made when needed, or on the disk."""

from __future__ import annotations

import math
import mmap
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import IO, Any, Protocol

import numpy as np

LARGE = 1 << 29  # bytes of numbers that are not kept in memory together


def is_large(n_arrays: int, length: int) -> bool:
    """Whether so many arrays of so many numbers of 8 bytes are not kept in memory together."""
    return 8 * n_arrays * length > LARGE


def kept_if_small(arrays: Mapping[str, np.ndarray], length: int) -> Mapping[str, np.ndarray]:
    """The arrays of this length themselves, or, if they are large together, as they were given."""
    return arrays if is_large(len(arrays), length) else dict(arrays)


class Sliced(Protocol):
    """An array (n,), or what reads elements of one from the disk: a slice, or rising indices."""

    def __len__(self) -> int: ...

    def __getitem__(self, where: Any, /) -> Any: ...


def in_parts(arrays: Mapping[str, np.ndarray], name: str) -> Sliced:
    """One of the arrays to be used a slice at a time: from the disk where it can be."""
    return arrays.in_parts(name) if isinstance(arrays, LazyArrays) else arrays[name]


class LazyArrays(Mapping[str, np.ndarray]):
    """Arrays by name, each made (read, computed) whenever it is asked for, and not kept.

    `in_parts`: as `make`, without the whole array in memory; by default `make`.
    """

    def __init__(
        self,
        names: Iterable[str],
        make: Callable[[str], np.ndarray],
        in_parts: Callable[[str], Sliced] | None = None,
    ):
        self._names = dict.fromkeys(names)
        self._make = make
        self.in_parts = in_parts or make

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._names:
            raise KeyError(name)
        return self._make(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __contains__(self, name: object) -> bool:
        return name in self._names  # Mapping's own would make it


class Scratch:
    """`values`: an array of float64, large ones in a file without a name in `folder`."""

    def __init__(self, shape: tuple[int, ...], folder: str | Path | None = None):
        size = math.prod(shape)
        self._map: mmap.mmap | None = None
        if folder is None or not is_large(1, size):
            self.values = np.empty(shape)
            return
        with tempfile.TemporaryFile(dir=folder) as file:
            file.truncate(8 * size)
            self._map = mmap.mmap(file.fileno(), 8 * size)
        self.values = np.frombuffer(self._map).reshape(shape)

    def put_away(self) -> None:
        """Write what is in memory to the disk; it is read again when it is used."""
        if self._map is not None:
            self._map.flush()
            if hasattr(self._map, "madvise"):  # not on every operating system
                self._map.madvise(mmap.MADV_DONTNEED)


class Spool:
    """Arrays of equal length (first axis) by name, in an open file."""

    def __init__(self, file: IO[bytes]):
        self._file = file
        self._starts: dict[str, int] = {}
        self.dtypes: dict[str, np.dtype[Any]] = {}
        self.size = 0

    def put(self, name: str, values: np.ndarray) -> None:
        """Append an array to the file; it is read back by its name."""
        self._starts[name] = self._file.seek(0, os.SEEK_END)
        self.dtypes[name], self.size = values.dtype, len(values)
        np.ascontiguousarray(values).tofile(self._file)

    def get(self, name: str, start: int, stop: int) -> np.ndarray:
        """Elements from `start` up to `stop`, or the end."""
        dtype, count = self.dtypes[name], min(stop, self.size) - start
        self._file.seek(self._starts[name] + start * dtype.itemsize)
        return np.fromfile(self._file, dtype, count)
