"""Recordings side by side: families of Allan deviations and coefficients, of S and of any group."""
