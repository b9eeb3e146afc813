"""Bayesian networks of operating conditions."""
