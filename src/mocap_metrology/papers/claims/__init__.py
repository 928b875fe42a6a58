"""Every claim of both papers that data can decide, by published and by regenerated numbers."""
