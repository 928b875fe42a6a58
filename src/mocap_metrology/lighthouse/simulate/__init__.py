"""Simulated recordings of a board moved before two base stations."""
