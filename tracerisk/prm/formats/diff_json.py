"""A change of risk as plain data for `--json`."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

from tracerisk.common.verdict import verdict_line
from tracerisk.prm.formats.assessment_json import mission_to_json
from tracerisk.prm.review.risk_diff import Review, RiskDiff


def review_to_json(review: Review) -> dict[str, Any]:
    """Return the review as data that `json.dumps` takes, keys as the fields are named.

    Added are what follows from the fields: the ratio of the mission's figures (`None` without a
    figure to compare with), each function's status, each change's causes.
    """
    plain = asdict(review)
    for name in ("prefixes", "folder", "others"):
        plain.pop(name)
    plain["controllers"] = [_diff_to_json(controller) for controller in review.controllers]
    readable: dict[str, Any] = _readable(plain)
    return readable


def _diff_to_json(diff: RiskDiff) -> dict[str, Any]:
    plain = asdict(diff)
    if not diff.is_comparable:
        # Of a run that went wrong a ratio or a contribution says nothing.
        functions = diff.functions if diff.is_other_mission else ()
        shown = replace(diff, changes=(), functions=functions, interaction=None, single_points=())
        diff, plain = shown, asdict(shown)
    for name, mission in (("before", diff.before), ("after", diff.after)):
        plain[name] = None if mission is None else mission_to_json(mission)
    functions_data = zip(plain["functions"], diff.functions, strict=True)
    changes = zip(plain["changes"], diff.changes, strict=True)
    return {
        **plain,
        "increase": diff.increase if diff.is_comparable else None,
        "ratio": diff.ratio if diff.is_comparable else None,
        "is_unchanged": diff.is_unchanged,
        "is_comparable": diff.is_comparable,
        "verdict_line": None if diff.verdicts is None else verdict_line(diff.verdicts.after),
        "new_acceptances": (
            [] if diff.verdicts is None else [asdict(e) for e in diff.verdicts.new_acceptances]
        ),
        "functions": [{**data, "status": function.status} for data, function in functions_data],
        "changes": [{**data, "causes": list(change.causes)} for data, change in changes],
    }


def _readable(value: Any) -> Any:
    """Replace what is not text: bytes that a source of another encoding holds in a reason."""
    if isinstance(value, dict):
        return {key: _readable(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_readable(entry) for entry in value]
    if isinstance(value, str):
        return value.encode(errors="replace").decode()
    return value
