"""Recordings as text: TRC, Motive and Vicon Nexus CSV, Qualisys TSV, poses; and covariates.

A module for each format, whose function `layout` reads the header; `read` and `rows` read the
numbers of all of them.
"""
