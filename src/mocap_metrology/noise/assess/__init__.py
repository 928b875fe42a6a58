"""What the noise of a recording means to who uses the system: uncertainties, verdict."""
