"""Noise of coordinates and distances of markers, by the question that is asked."""
