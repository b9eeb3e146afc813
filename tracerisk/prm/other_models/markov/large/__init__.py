"""Chains of up to a million states, on arrays."""

from tracerisk.common.dependencies import require_large
from tracerisk.prm.compiled.library import require_library

require_large("numpy", "scipy")
require_library("a chain of this size")
