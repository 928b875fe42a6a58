"""How good a calibration is: references, checks, a verdict."""
