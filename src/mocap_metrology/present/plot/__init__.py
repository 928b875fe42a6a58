"""One look for every figure: style, figure, curves, decimation."""
