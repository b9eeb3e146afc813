"""Plain data as JSON can hold it: without infinite numbers."""

from __future__ import annotations

import math
from enum import Enum
from typing import Any


def finite(value: Any) -> Any:
    """Return plain data with `None` for each number that is infinite or none."""
    if isinstance(value, dict):
        return {key: finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [finite(entry) for entry in value]
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
