"""C3D files: their structure, positions of markers in mm, and writing them.

Nothing else in this project reads or writes C3D. `structure.inspect` checks a file without reading
data, `read.read_c3d` reads chosen markers of one file or of several segments, `write.write_c3d`
writes.
"""
