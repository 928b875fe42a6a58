"""Noise coefficients of a series, by every estimator."""
