"""Accuracy of a system: known lengths, reference points, a facility over time."""
