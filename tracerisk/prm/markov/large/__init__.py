"""Chains of up to a million states, on arrays."""
