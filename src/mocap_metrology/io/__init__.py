"""Recordings: bytes to trajectories in mm and back, for C3D files and for text of any program."""
