"""What all figures are drawn with: looks, axes, legends, curves."""
