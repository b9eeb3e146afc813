"""An assessment as plain data for `--json`."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from tracerisk.prm.hybrid.assessment import Assessment


def assessment_to_json(assessment: Assessment) -> dict[str, Any]:
    """Return the assessment as data that `json.dumps` takes, keys as the fields are named.

    An infinite ratio (without the component nothing fails at all) is `None`, JSON's null.
    """
    plain: dict[str, Any] = finite(asdict(assessment))
    return plain


def finite(value: Any) -> Any:
    """Return plain data with `None` for each number that is infinite or none."""
    if isinstance(value, dict):
        return {key: finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [finite(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
