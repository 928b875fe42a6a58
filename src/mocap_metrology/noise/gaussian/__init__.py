"""The simple Gaussian model of two markers and their distance."""
