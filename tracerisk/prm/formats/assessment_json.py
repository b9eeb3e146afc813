"""An assessment as plain data for `--json`."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from tracerisk.prm.assessment import Assessment


def assessment_to_json(assessment: Assessment) -> dict[str, Any]:
    """Return the assessment as data that `json.dumps` takes, keys as the fields are named.

    An infinite ratio (without the component nothing fails at all) is `None`, JSON's null.
    """
    plain: dict[str, Any] = _finite(asdict(assessment))
    return plain


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
