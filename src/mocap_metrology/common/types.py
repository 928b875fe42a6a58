"""Names of types that many modules share."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Columns = dict[str, np.ndarray]  # of a table
Row = dict[str, object]  # of a table: numbers, words, gaps
Record = Mapping[str, Any]  # a row as read from CSV, or what a JSON file holds
