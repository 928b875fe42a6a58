"""Pose of a receiver along a recording, with calibrated stations."""
