"""Noise coefficients from Allan variances: the estimators of S."""
