"""Tables of a group of recordings."""
