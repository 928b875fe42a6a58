"""C3D files: their structure, positions of markers in mm, and writing them.

Nothing else in this project reads or writes C3D. `structure.inspect` checks a file without reading
data, `read.readers` reads chosen markers, `write.write_c3d` writes.
"""
