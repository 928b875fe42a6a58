"""Jansen et al. 2019: its tables and figures."""
