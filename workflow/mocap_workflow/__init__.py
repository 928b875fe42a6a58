"""What the workflow does at start-up: configuration, sheets, source hashes, one run at a time."""

VERSION = "0.1.0"  # of the package that the workflow runs, see pyproject.toml
