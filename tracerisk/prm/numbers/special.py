"""The special functions of scipy, imported when one is first used."""

from __future__ import annotations

from typing import Any

from tracerisk.common.dependencies import require_large


def special() -> Any:
    """Return `scipy.special`; raise DependencyError where scipy is not installed."""
    require_large("scipy")
    import scipy.special

    return scipy.special
