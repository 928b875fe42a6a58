"""Changes to the meaning of one line of the package, and whether the tests that reach it fail.

`python -m tests.mutants` runs a seeded sample; CONTRIBUTING.md has the options.
"""
