"""Simulated studies: how the error of a calibration depends on one circumstance at a time."""
