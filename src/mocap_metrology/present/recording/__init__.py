"""Figures of one recording: deviations, spectrum, trajectory."""
