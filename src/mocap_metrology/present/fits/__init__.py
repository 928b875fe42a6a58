"""The figure of a noise fit and its parts."""
