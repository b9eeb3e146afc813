"""An assessment as plain data for `--json`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from tracerisk.common.text.finite import finite
from tracerisk.prm.hybrid.assessment import Assessment


def assessment_to_json(assessment: Assessment) -> dict[str, Any]:
    """Return the assessment as data that `json.dumps` takes, keys as the fields are named.

    An infinite ratio (without the component nothing fails at all) is `None`, JSON's null.
    """
    plain: dict[str, Any] = finite(asdict(assessment))
    states: list[dict[str, Any]] = plain["states"]
    for row in (*plain["components"], *(row for state in states for row in state["components"])):
        # Left out: the parameter's name already holds the component.
        del row["component"]
    return plain
