"""C3D files: what they say about themselves, positions of markers in mm, and writing them.

Nothing else in this project reads or writes C3D. `inspect` checks a file without reading data,
`read_recording` reads chosen markers of one file or of several segments, `write_c3d` writes.
"""

from mocap_metrology.c3d.recording import Recording, Segment, read_recording
from mocap_metrology.c3d.structure import Structure, inspect
from mocap_metrology.c3d.write import C3DWriter, write_c3d

__all__ = [
    "C3DWriter",
    "Recording",
    "Segment",
    "Structure",
    "inspect",
    "read_recording",
    "write_c3d",
]
