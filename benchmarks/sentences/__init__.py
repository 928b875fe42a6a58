"""Monte Carlo behind docs/accuracy.md; one module a subject, each with `rows(n)`."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "workflow"))  # twins are read there
