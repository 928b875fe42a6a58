"""Noise of coordinates and distances of markers, one folder for each question.

The package can be called: `noise(values, rate_hz)` is `noise.coefficients.coefficients`, so that
`mocap_metrology.noise` is both this package and the public function of that name.
"""

import sys
from types import ModuleType
from typing import Any


class _Called(ModuleType):
    def __call__(self, *arguments: Any, **options: Any) -> Any:
        from mocap_metrology.noise.coefficients import coefficients

        return coefficients(*arguments, **options)


sys.modules[__name__].__class__ = _Called
