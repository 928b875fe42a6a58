"""The command `mocap-metrology`."""
