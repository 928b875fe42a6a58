"""Lighthouse: from optical pulses on photodiodes to the poses of base stations in one of them.

Frames and units: a base station looks along its x axis, y to its own left, z up; metres, seconds,
radians. Station 0 is the master, whose flash comes first in the cycle, station 1 the slave;
p_master = R p_slave + t. Axis 0 turns about z and measures atan2(y, x), axis 1 measures
atan2(z, x). Stations of the second generation (V2) and their planes are described in `records`.
"""

RECORDING_FORMATS = (
    "gpio-dump",
    "libsurvive-rec",
    "crazyflie-uart",
    "crazyflie-log",
    "angles-csv",
    "lfsr-counts",
)
