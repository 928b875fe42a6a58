"""A kind of input: a sound file, how the package reads it, how a strict reader does."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .strict_c3d import Values


@dataclass(frozen=True)
class Kind:
    """`base`: a sound file; `read`: the package's values of a file; `strict`: those of its bytes;
    `damage`: a mutant and what was done."""

    name: str
    file: str
    base: bytes
    read: Callable[[Path], Values]
    strict: Callable[[bytes], Values]
    damage: Callable[[bytes, np.random.Generator], tuple[bytes, str]]

    @property
    def is_c3d(self) -> bool:
        return self.name.startswith("c3d")
