"""Pulses, flashes, calibration frames and sweeps from recordings."""
