"""Fuzzing: damaged inputs of every kind, read in child processes, judged by independent parsers.

`python -m tests.fuzz` is the long run; `test_fuzz.py` a short one.
"""
