"""Joint estimation of station poses and the board's trajectory from time-stamped hits."""
