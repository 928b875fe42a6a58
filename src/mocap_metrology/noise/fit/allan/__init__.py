"""Noise coefficients from Allan variances: the estimators of S, and one with full covariance."""
