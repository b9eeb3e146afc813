"""Chains of up to a million states, on arrays."""

from tracerisk.dependencies import require_large

require_large("numpy", "scipy", "numba")
