"""What the workflow does at start-up, in plain Python: configuration, sheets, digests, one run."""
