"""Recordings held against each other, and over dates."""
