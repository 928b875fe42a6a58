"""Noise of an orientation, and by place."""
