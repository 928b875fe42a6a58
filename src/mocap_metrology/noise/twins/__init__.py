"""Simulated stand-ins for recordings that were never published."""
