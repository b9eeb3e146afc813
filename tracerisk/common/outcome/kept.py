"""An outcome as the lock keeps it: short lines that a reviewer can read, a few kB at most."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

from tracerisk.common.outcome.arm import Arm, ArmFrame, Position
from tracerisk.common.outcome.changes import OutcomeChanges, outcome_changes
from tracerisk.common.outcome.outcome import (
    CORNER_M,
    TICK_S,
    CellCount,
    CellUse,
    CellUseKind,
    GripperUse,
    ObjectOutcome,
    Outcome,
    Rest,
    rest_of,
    rounded,
)
from tracerisk.common.outcome.tolerances import TOLERANCES, Tolerances
from tracerisk.common.outcome.ways import corners

OUTCOME = "outcome"
MOST_BYTES = 3900
"""What an outcome may take in the lock; corners of ways go first, then the last steps."""
_CORNERS_M = (0.006, 0.012, 0.025, 0.05)
_KINDS: dict[str, CellUseKind] = {"C": "call", "M": "message", "G": "goal"}
_LETTERS = {kind: letter for letter, kind in _KINDS.items()}
_STEP = ";"
_SIGNS = "%|;@,/ \t\r\n"
_IN_CONTENT = "%;\r\n"


def outcome_summary(outcome: Outcome | None, tolerances: Tolerances = TOLERANCES) -> dict[str, Any]:
    """Return what the lock keeps of an outcome; nothing where none is known.

    `tolerances` that the settings give are kept with it.
    """
    if outcome is None:
        return {}
    kept = _data(outcome)
    for corner_m in (*_CORNERS_M, 0.0):
        if _size(kept) <= MOST_BYTES:
            break
        outcome = _with_fewer_corners(outcome, corner_m)
        kept = _data(outcome)
    number = len(outcome.steps)
    while _size(kept) > MOST_BYTES and number > 0:
        number = number * 9 // 10
        outcome = _first(outcome, number)
        kept = _data(outcome)
    if tolerances != TOLERANCES:
        kept["tolerances"] = asdict(tolerances)
    return {OUTCOME: kept}


def kept_tolerances(summary: Mapping[str, Any]) -> Tolerances:
    """Return the tolerances that are kept with an outcome; the usual ones where there are none."""
    data = summary.get(OUTCOME)
    given = data.get("tolerances") if isinstance(data, dict) else None
    if not isinstance(given, dict) or given.keys() != asdict(TOLERANCES).keys():
        return TOLERANCES
    values = list(given.values())
    if not all(type(value) is float and value > 0.0 for value in values):
        return TOLERANCES
    return Tolerances(**given)


def kept_changes(before: Mapping[str, Any], after: Mapping[str, Any]) -> OutcomeChanges | None:
    """Return how the outcomes of two locks' summaries differ; `None` where one is unknown.

    The smaller tolerances of both count: no change widens those it is judged by.
    """
    old, new = kept_outcome(before), kept_outcome(after)
    if old is None or new is None:
        return None
    allowed = kept_tolerances(before), kept_tolerances(after)
    tolerances = Tolerances(
        min(tolerance.place_m for tolerance in allowed),
        min(tolerance.angle_deg for tolerance in allowed),
        min(tolerance.joint for tolerance in allowed),
    )
    return outcome_changes(old, new, tolerances)


def kept_outcome(summary: Mapping[str, Any]) -> Outcome | None:
    """Return the outcome that a lock's summary keeps; `None` where it is unknown or malformed."""
    data = summary.get(OUTCOME)
    if not isinstance(data, dict):
        return None
    try:
        return _outcome(data)
    except (ValueError, KeyError, TypeError, IndexError, AttributeError):
        return None


def _size(data: Mapping[str, Any]) -> int:
    """Return what it takes in the lock, where each line stands five levels deep."""
    text = json.dumps(data, indent=1)
    return len(text) + 4 * text.count("\n")


def _with_fewer_corners(outcome: Outcome, corner_m: float) -> Outcome:
    """Return an outcome whose ways lie `corner_m` from the lines between their corners; 0: none."""
    rests: list[Rest] = []
    last: dict[int, Position] = {}
    for rest in outcome.rests:
        begin = last.get(rest.arm, rest.from_m or rest.tool_m)
        way = (begin, *rest.via_m, rest.tool_m)
        via = corners(way, corner_m) if corner_m and rest.via_m else []
        rests.append(replace(rest, via_m=tuple(via)))
        last[rest.arm] = rest.tool_m
    return replace(outcome, rests=tuple(rests), corner_m=corner_m)


def _first(outcome: Outcome, number: int) -> Outcome:
    """Return an outcome with its first steps, and the last rest of each arm."""
    last = {rest.arm: rest.order for rest in outcome.rests}.values()
    kept = [step for step in outcome.steps if step.order < number or step.order in last]
    left_out = outcome.left_out + len(outcome.steps) - len(kept)
    return replace(
        outcome,
        rests=tuple(step for step in kept if isinstance(step, Rest)),
        grips=tuple(step for step in kept if isinstance(step, GripperUse)),
        cell=tuple(step for step in kept if isinstance(step, CellUse)),
        left_out=left_out,
        counts=outcome.cell_counts if left_out else (),
    )


# Out


def _data(outcome: Outcome) -> dict[str, Any]:
    data: dict[str, Any] = {
        "arms": [_arm_text(arm) for arm in outcome.arms],
        "grippers": _grippers(outcome),
        "objects": [_object_text(object_outcome) for object_outcome in outcome.objects],
        "way": list(_way_lines(outcome)),
    }
    if outcome.streams:
        data["streams"] = list(outcome.streams)
    if outcome.corner_m != CORNER_M:
        data["corner_mm"] = round(1000.0 * outcome.corner_m)
    if outcome.left_out:
        data["left_out"] = outcome.left_out
        data["counts"] = [
            f"{_LETTERS[count.kind]} {count.interface} {count.uses} {count.succeeded}"
            for count in outcome.counts
        ]
    return {key: value for key, value in data.items() if value not in ([], "")}


def _grippers(outcome: Outcome) -> list[str]:
    return sorted({use.gripper for use in outcome.grips})


def _arm_text(arm: Arm) -> str:
    """Return an arm: its joints, then how each link hangs on the one before, in 0.1 mm and mrad."""
    return "|".join((" ".join(map(_escaped, arm.joints)), *map(_frame_text, arm.frames)))


def _frame_text(frame: ArmFrame) -> str:
    numbers = [_tenths_of_mm(frame.xyz_m), _tenths_of_mm(frame.rpy)]
    if frame.joint:
        numbers.append(_tenths_of_mm(frame.axis))
        numbers.append(_escaped(frame.joint) + ("/" if frame.slides else ""))
    return ",".join(numbers)


def _tenths_of_mm(values: Position) -> str:
    """Return three numbers in steps of 1e-4, without what is 0 in all."""
    return " ".join(str(round(10000.0 * value)) for value in values) if any(values) else ""


def _object_text(found: ObjectOutcome) -> str:
    end = "" if found.end_m == found.begin_m else _steps(found.end_m)
    heading = "-" if found.heading_deg is None else f"{found.heading_deg:.0f}"
    return (
        f"{_escaped(found.name)}|{_steps(found.begin_m)}|{end}|{found.tilt_deg:.0f} "
        f"{heading}|{_escaped(found.rests_on)}|{_escaped(found.held_in)}"
    )


def _way_lines(outcome: Outcome) -> Iterator[str]:
    """Yield the steps in order, as many in a line as are easy to read."""
    known: dict[tuple[int, tuple[float, ...]], int] = {}
    grippers = _grippers(outcome)
    line: list[str] = []
    for step in outcome.steps:
        if isinstance(step, Rest):
            text = _rest_text(step, known)
        elif isinstance(step, GripperUse):
            number = grippers.index(step.gripper)
            text = f"g{number} {100.0 * step.opened:.0f} {_escaped(step.holds)}".rstrip()
        else:
            mark = "" if step.succeeded else "!"
            content = _escaped(step.content, _IN_CONTENT)
            text = f"{_LETTERS[step.kind]}{mark} {step.interface} {content}".rstrip()
        if line and sum(map(len, line)) + len(text) > _WIDTH:
            yield _STEP.join(line)
            line = []
        line.append(text)
    if line:
        yield _STEP.join(line)


_WIDTH = 400


def _rest_text(rest: Rest, known: dict[tuple[int, tuple[float, ...]], int]) -> str:
    """Return a rest in whole mrad or mm; one that was there before by its number."""
    key = rest.arm, rest.joints
    times = f"{_ticks(rest.took_s)} {_ticks(rest.held_s)}"
    way = "" if rest.from_m is None else f" from {_steps(rest.from_m)}"
    way += f" via {','.join(map(_steps, rest.via_m))}" if rest.via_m else ""
    if key in known:
        return f"={known[key]} {times}{way}"
    known[key] = len(known)
    arm = f"{rest.arm}" if rest.arm else ""
    return f"r{arm} {_steps(rest.joints)}@{times}{way}"


def _steps(values: Sequence[float]) -> str:
    return " ".join(str(round(1000.0 * value)) for value in values)


def _ticks(seconds: float) -> str:
    return str(round(seconds / TICK_S))


def _escaped(text: str, signs: str = _SIGNS) -> str:
    """Return a text without the signs that part what is kept: these as %XX."""
    return "".join(f"%{ord(sign):02X}" if sign in signs else sign for sign in text)


def _unescaped(text: str) -> str:
    return re.sub("%([0-9A-F]{2})", lambda found: chr(int(found[1], 16)), text)


# Back


def _outcome(data: Mapping[str, Any]) -> Outcome:
    rests: list[Rest] = []
    grips: list[GripperUse] = []
    cell: list[CellUse] = []
    known: list[Rest] = []
    arms = tuple(map(_read_arm, data.get("arms", ())))
    steps = [text for line in data.get("way", ()) for text in line.split(_STEP)]
    for order, text in enumerate(steps):
        letter, _, rest = text.partition(" ")
        if letter[0] in "r=":
            rests.append(_read_rest(letter, rest, order, known, arms))
        elif letter[0] == "g":
            opened, _, holds = rest.partition(" ")
            gripper = data["grippers"][int(letter[1:])]
            grips.append(GripperUse(order, gripper, int(opened) / 100.0, _unescaped(holds)))
        else:
            interface, _, content = rest.partition(" ")
            kind = _KINDS[letter[0]]
            went_well = not letter.endswith("!")
            cell.append(CellUse(order, kind, interface, _unescaped(content), went_well))
    return Outcome(
        arms=arms,
        objects=tuple(map(_read_object, data.get("objects", ()))),
        rests=tuple(rests),
        grips=tuple(grips),
        cell=tuple(cell),
        streams=tuple(data.get("streams", ())),
        corner_m=int(data.get("corner_mm", 1000.0 * CORNER_M)) / 1000.0,
        left_out=int(data.get("left_out", 0)),
        counts=tuple(map(_read_count, data.get("counts", ()))),
    )


def _read_count(text: str) -> CellCount:
    letter, interface, uses, succeeded = text.split(" ")
    return CellCount(interface, _KINDS[letter], int(uses), int(succeeded))


def _read_arm(text: str) -> Arm:
    joints, *frames = text.split("|")
    return Arm(tuple(map(_unescaped, joints.split(" "))), tuple(map(_read_frame, frames)))


def _read_frame(text: str) -> ArmFrame:
    xyz, rpy, *moving = text.split(",")
    place, turn = _read_tenths(xyz), _read_tenths(rpy)
    if not moving:
        return ArmFrame(place, turn)
    axis, joint = moving
    name = _unescaped(joint.removesuffix("/"))
    return ArmFrame(place, turn, name, _read_tenths(axis), joint.endswith("/"))


def _read_tenths(text: str) -> Position:
    x, y, z = (int(value) / 10000.0 for value in text.split(" ")) if text else (0.0, 0.0, 0.0)
    return x, y, z


def _read_object(text: str) -> ObjectOutcome:
    name, begin, end, turned, rests_on, held_in = text.split("|")
    begin_m = _read_position(begin)
    tilt, heading = turned.split(" ")
    return ObjectOutcome(
        _unescaped(name),
        begin_m,
        _read_position(end) if end else begin_m,
        float(tilt),
        None if heading == "-" else float(heading),
        _unescaped(rests_on),
        _unescaped(held_in),
    )


def _read_rest(letter: str, text: str, order: int, known: list[Rest], arms: Sequence[Arm]) -> Rest:
    text, _, via = text.partition(" via ")
    text, _, begin = text.partition(" from ")
    if letter[0] == "=":
        before, times = known[int(letter[1:])], text
        number, joints = before.arm, before.joints
    else:
        joints_text, times = text.split("@")
        number, joints = int(letter[1:] or 0), _read_steps(joints_text)
    took, held = times.split(" ")
    rest = rest_of(
        arms[number],
        joints,
        order=order,
        number=number,
        took_s=rounded(int(took) * TICK_S, TICK_S),
        held_s=rounded(int(held) * TICK_S, TICK_S),
        via_m=[_read_position(corner) for corner in via.split(",")] if via else (),
        from_m=_read_position(begin) if begin else None,
    )
    if letter[0] == "r":
        known.append(rest)
    return rest


def _read_steps(text: str) -> tuple[float, ...]:
    return tuple(int(value) / 1000.0 for value in text.split(" ")) if text else ()


def _read_position(text: str) -> Position:
    x, y, z = _read_steps(text)
    return x, y, z
