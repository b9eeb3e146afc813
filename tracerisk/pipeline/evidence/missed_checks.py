"""What would have shown an undetected failure to a controller, and where it would stand."""

from __future__ import annotations

import math

from tracerisk.common.evidence.cells import Cell, MissedCheck
from tracerisk.common.hardware.model import FAULTS, mode_and_duration
from tracerisk.pipeline.evidence.mission_run import MissionRun
from tracerisk.pipeline.evidence.reaction import AT_ONCE_S, Reaction
from tracerisk.pipeline.run.fault_run import new_reports

_SECOND_NS = 1_000_000_000


def missed_check(
    nominal: MissionRun, failed: MissionRun, cell: Cell, reaction: Reaction, effect_s: float
) -> tuple[MissedCheck, str] | None:
    """Return what would have shown the failure of a cell first, and its place as `file:line`.

    That is the first answer which said that something failed, and to which the controller did not
    react; else, of a gripper, its width after the last command of it before the effect; else a
    limit to the wait in which the run ended. `effect_s` is when the effect came [s]. `None` where
    nothing is known.
    """
    ignored = _ignored_answer(nominal, failed, cell, reaction)
    if ignored:
        return "result", ignored
    if mode_and_duration(cell.mode)[0] in FAULTS["gripper"]:
        grips = [command for command in failed.commands if cell.unit in command.elements]
        before = [command for command in grips if command.issue_ns / _SECOND_NS <= effect_s]
        for command in before[-1:] or grips[:1]:
            innermost = command.stack[-1]
            return "grip", f"{innermost.function.file}:{innermost.site[0]}"
    if nominal.has_ended and not failed.has_ended and not failed.is_decided:
        place = failed.trace.end.location
        if place is not None and place.line is not None:
            return "time_limit", f"{place.file}:{place.line}"
    return None


def _ignored_answer(nominal: MissionRun, failed: MissionRun, cell: Cell, reaction: Reaction) -> str:
    """Return where the first bad answer came without a reaction; empty for none."""
    noticed_s = math.inf if reaction.noticed_s is None else reaction.noticed_s
    usual = {(sign.name, sign.file, sign.line) for sign in nominal.recording.signs}
    answered = [
        (sign.ns / _SECOND_NS, f"{sign.file}:{sign.line}")
        for sign in failed.recording.signs
        if sign.by != "log" and sign.line and (sign.name, sign.file, sign.line) not in usual
    ]
    for finding in new_reports(nominal.trace, failed.trace, cell.time_s):
        place = finding.location
        if place is not None and place.line is not None:
            answered.append((finding.time_s or 0.0, f"{place.file}:{place.line}"))
    late = [item for item in answered if cell.time_s <= item[0] < noticed_s - AT_ONCE_S]
    return min(late, default=(0.0, ""))[1]
