"""Names of types that many modules share."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Booleans = npt.NDArray[np.bool_]
Row = dict[str, object]  # of a table: numbers, words, gaps
Record = Mapping[str, object]  # a row that is only read, or an object of a JSON file
Json = None | bool | int | float | str | list["Json"] | dict[str, "Json"]
