"""What the workflow does at start-up: configuration, sheets, source hashes, one run at a time."""
