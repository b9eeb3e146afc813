"""The file of a field profile: JSON, read and written."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

from tracerisk.common.field.profile import QUANTITIES, Estimate, FieldProfile, FieldStep, following
from tracerisk.common.text.bounded import file_text
from tracerisk.errors import InputError, Location

SCHEMA = "tracerisk/field/1"
_MOST_BYTES = 64 * 1024**2


def field_data(found: FieldProfile) -> dict[str, Any]:
    """Return a profile as JSON data."""
    return {
        "schema": SCHEMA,
        "controller": found.controller,
        "robot": found.robot,
        "missions": found.missions,
        "duration_s": found.duration_s,
        "functions": {
            step.name: {
                "visits": step.visits,
                "per_mission": _estimate_data(step.per_mission),
                "duration_s": None if step.duration_s is None else _estimate_data(step.duration_s),
                "next": {
                    target: {
                        "count": following.count,
                        "share": str(following.share),
                        "low": following.low,
                        "high": following.high,
                    }
                    for target, following in step.following.items()
                },
                "uses": {
                    element: {name: _estimate_data(estimate) for name, estimate in row.items()}
                    for element, row in step.uses.items()
                },
            }
            for step in found.steps
        },
        "totals": {element: dict(row) for element, row in found.totals.items()},
    }


def dump_field(found: FieldProfile) -> str:
    """Return the text of the file."""
    return json.dumps(field_data(found), indent=1) + "\n"


def read_field(path: Path) -> FieldProfile:
    """Return the profile of a file; raise InputError with what is malformed."""
    where = Location(str(path))
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise InputError(f"has more than {_MOST_BYTES} bytes; is it a field profile?", where)
        data = json.loads(file_text(path, most=_MOST_BYTES))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot be read: {error}", where) from error
    except (ValueError, RecursionError) as error:
        line = getattr(error, "lineno", None)
        raise InputError(f"is not JSON: {error}", Location(str(path), line)) from error
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        raise InputError(
            f"is not a field profile: expected the schema '{SCHEMA}'; `tracerisk field` writes "
            "one from recordings",
            where,
        )
    try:
        return _profile(data)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"is malformed: {type(error).__name__}: {error}", where) from error


def _profile(data: Mapping[str, Any]) -> FieldProfile:
    steps = tuple(_step(name, row) for name, row in data["functions"].items())
    totals = {
        str(element): {name: _number(row[name]) for name in QUANTITIES if name in row}
        for element, row in data["totals"].items()
    }
    duration = data["duration_s"]
    return FieldProfile(
        controller=str(data["controller"]),
        robot=str(data["robot"]),
        missions=_count(data["missions"]),
        steps=steps,
        totals=totals,
        duration_s=None if duration is None else _number(duration),
    )


def _step(name: str, row: Mapping[str, Any]) -> FieldStep:
    counts = {str(target): _count(item["count"]) for target, item in row["next"].items()}
    followings = following(counts) if any(counts.values()) else {}
    for target, item in followings.items():
        if Fraction(row["next"][target]["share"]) != item.share:
            raise ValueError(f"next {target} of {name}: its share does not match its count")
    duration = row["duration_s"]
    return FieldStep(
        name=name,
        visits=_count(row["visits"]),
        per_mission=_estimate(row["per_mission"]),
        duration_s=None if duration is None else _estimate(duration),
        uses={
            str(element): {key: _estimate(use) for key, use in uses.items() if key in QUANTITIES}
            for element, uses in row["uses"].items()
        },
        following=followings,
    )


def _estimate_data(found: Estimate) -> dict[str, float | None]:
    return {"mean": found.mean, "low": found.low, "high": found.high}


def _estimate(data: Mapping[str, Any]) -> Estimate:
    low, high = (None if data[key] is None else _number(data[key]) for key in ("low", "high"))
    return Estimate(_number(data["mean"]), low, high)


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"expected a number, not {value!r}")
    return float(value)


def _count(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise ValueError(f"expected a count, not {value!r}")
    return value
