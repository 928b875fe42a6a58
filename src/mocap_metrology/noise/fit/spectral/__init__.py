"""Noise coefficients from the periodogram: maximum likelihood, and the Cramer-Rao bound."""
