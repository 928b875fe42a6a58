"""Recordings: bytes to trajectories in mm and back, for C3D files and for text of any program.

`read` is what others use: `read_recording`, `labels_of`, `bodies_of`, `orientation_of`; and
`c3d.write`, `text.covariate`.
"""
