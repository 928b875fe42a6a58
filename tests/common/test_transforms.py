"""Transforms of long series: scipy's numbers, and nothing left behind."""

import subprocess
import sys

import numpy as np
import pytest
import scipy.fft

from mocap_metrology.common import transforms

LEFT = """
import os
import numpy as np
from mocap_metrology.common import transforms
transforms.LONG = {long}
def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
for call in (transforms.dct, transforms.rfft, transforms.irfft):
    call(np.ones(100))
values, before = np.ones(1 << 21), resident()
for call in (transforms.dct, transforms.rfft, transforms.irfft):
    call(values)
print((resident() - before) / values.nbytes)
"""


def test_same_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(transforms, "LONG", 10)
    values = np.random.default_rng(1).normal(size=1000)
    np.testing.assert_array_equal(
        transforms.dct(values, norm="ortho"), scipy.fft.dct(values, norm="ortho")
    )
    spectrum = transforms.rfft(values)
    np.testing.assert_array_equal(spectrum, scipy.fft.rfft(values))
    np.testing.assert_array_equal(transforms.irfft(spectrum, 999), scipy.fft.irfft(spectrum, 999))


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_nothing_is_left() -> None:
    """Of the tables of three transforms; were they kept, several times the series."""

    def left(long: int) -> float:
        command = [sys.executable, "-c", LEFT.format(long=long)]
        return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)

    assert left(1 << 24) > 3
    assert left(1 << 10) < 0.5
