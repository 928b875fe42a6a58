"""Models of noise: components, their spectra and Allan variances, and series drawn from them."""
