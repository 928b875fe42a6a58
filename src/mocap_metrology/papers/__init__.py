"""Statistics that only the two papers need."""
