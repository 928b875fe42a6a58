"""A Lighthouse calibration: its figure and its table."""
