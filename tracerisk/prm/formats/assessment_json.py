"""An assessment as plain data for `--json`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from tracerisk.common.text.finite import finite
from tracerisk.prm.hybrid.assessment import Assessment, MissionFigures


def assessment_to_json(assessment: Assessment) -> dict[str, Any]:
    """Return the assessment as data that `json.dumps` takes, keys as the fields are named.

    An infinite ratio (without the component nothing fails at all) is `None`, JSON's null.
    """
    plain: dict[str, Any] = finite(asdict(assessment))
    states: list[dict[str, Any]] = plain["states"]
    unseen: list[dict[str, Any]] = plain.pop("undetected_components")
    if unseen:
        plain["undetected_components"] = unseen
    of_states = (row for state in states for row in state["components"])
    for row in (*plain["components"], *unseen, *of_states):
        # Left out: the parameter's name already holds the component.
        del row["component"]
    plain["mission"] = mission_to_json(assessment.mission)
    return plain


def mission_to_json(mission: MissionFigures) -> dict[str, Any]:
    """Return a mission's figures without those of its ends where no model says what they are."""
    ends = ("undetected_", "stopped_")
    plain = {**asdict(mission), "undetected_fraction": mission.undetected_fraction}
    return {
        key: value
        for key, value in finite(plain).items()
        if value is not None or not key.startswith(ends)
    }
