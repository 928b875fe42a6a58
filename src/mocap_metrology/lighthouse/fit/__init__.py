"""Searches for a pose from angles: the cost of J, its two minimisers, and poses of the board."""
