"""Series of what moves or turns: orientation, place in the volume, and whether a marker moves."""
