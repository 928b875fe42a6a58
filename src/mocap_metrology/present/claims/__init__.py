"""Every claim of both papers that data can decide, held against published numbers and twins."""
