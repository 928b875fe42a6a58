"""A calibration for programs that track with the stations: poses in a frame of the room, in their
own files."""
