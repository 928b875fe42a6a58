"""Simulated recordings that stand in for those that were never published."""
