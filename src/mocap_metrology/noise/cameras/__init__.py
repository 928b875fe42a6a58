"""Camera subsets of one take: does the noise fall with each camera, and which one raises it."""
