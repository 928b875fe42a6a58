"""Noise of coordinates and distances of markers, one folder for each question."""
