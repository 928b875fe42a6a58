"""How far from the truth a system measures: what moves, or has a known length or place."""
