"""What a run brought about: where objects end, where the arm rests, what the cell was asked for.

No function of the controller is named in it: how the code is cut is no outcome. Every figure is
rounded to a whole number of small steps, so that the processor decides none.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from tracerisk.common.geometry.rotation import Quaternion
from tracerisk.common.outcome.arm import Arm, Position, tool_pose

CellUseKind = Literal["call", "message", "goal"]
CORNER_M = 0.003
"""How far a way may lie from the lines between its corners, where there is room for them [m]."""
TICK_S = 0.05
"""The step of the times of rests, [s]."""
FLOOR = "floor"
"""What an object rests on that touches nothing with a name."""
_SMALL = 1e-3
_EDGE = 1e-4  # of a step: half a step, as round figures have it, is always rounded up


def rounded(value: float, step: float = 0.001) -> float:
    """Return a value as a whole number of steps, by default of 1 mm or 1 mrad."""
    whole = math.floor(value / step + 0.5 + _EDGE)
    return round(whole * step, 6) + 0.0


def rounded_position(values: Iterable[float]) -> Position:
    """Return a place in whole millimetres, in [m]."""
    x, y, z = (rounded(float(value)) for value in values)
    return x, y, z


@dataclass(frozen=True, slots=True)
class ObjectOutcome:
    """Where an object that can be moved began and ended, in the frame of the scene."""

    name: str
    """The name of the object in the scene."""
    begin_m: Position
    """Where its origin was at the beginning, [m]."""
    end_m: Position
    """Where its origin was at the end, [m]."""
    tilt_deg: float
    """The angle between its own z axis and the vertical at the end, [deg]."""
    heading_deg: float | None
    """By how much it was turned about the vertical since the beginning, [deg]; `None` if round."""
    rests_on: str
    """What it touched at the end, names joined by `+`; empty for nothing."""
    held_in: str
    """The gripper or link that held it at the end; empty for none."""


@dataclass(frozen=True, slots=True)
class Rest:
    """A posture in which an arm came to rest."""

    order: int
    """Its place among all steps of the run."""
    joints: tuple[float, ...]
    """The positions of the arm's joints, [rad or m]; their names are those of the arm."""
    tool_m: Position
    """Where the arm's tool was, in the frame of the robot's base, [m]."""
    tool_turn: Quaternion
    """How the tool was turned there, (w, x, y, z)."""
    held_s: float
    """For how long the arm rested there, [s]."""
    took_s: float
    """How long the way there took since the rest before, [s]."""
    arm: int = 0
    """Which arm it is, by its place in `Outcome.arms`."""
    via_m: tuple[Position, ...] = ()
    """The corners of the tool's way there from the rest before, [m]."""
    from_m: Position | None = None
    """Where the tool began, of an arm's first rest, [m]; `None` for others, or where unknown."""


def rest_of(
    arm: Arm,
    joints: Iterable[float],
    *,
    order: int = 0,
    number: int = 0,
    took_s: float = 0.0,
    held_s: float = 0.0,
    via_m: Iterable[Position] = (),
    from_m: Position | None = None,
) -> Rest:
    """Return the rest of an arm in a posture; the tool is where its kinematics say.

    joints: (n_joints,), positions [rad or m]; `number` is the place of the arm in the outcome.
    """
    posture = tuple(rounded(position) for position in joints)
    place, turn = tool_pose(arm, posture)
    sign = -1.0 if next((value for value in turn if abs(value) > _SMALL), 1.0) < 0.0 else 1.0
    w, x, y, z = (rounded(sign * value, 0.0001) for value in turn)
    return Rest(
        order,
        posture,
        rounded_position(place),
        (w, x, y, z),
        held_s,
        took_s,
        number,
        tuple(via_m),
        from_m,
    )


@dataclass(frozen=True, slots=True)
class GripperUse:
    """A command to a gripper, with what it did."""

    order: int
    """Its place among all steps of the run."""
    gripper: str
    """The name of the gripper."""
    opened: float
    """How far the gripper was open afterwards: 0 closed, 1 wide open."""
    holds: str
    """The object that it held afterwards; empty for nothing."""


@dataclass(frozen=True, slots=True)
class CellUse:
    """A call, message or goal to anything but the arm."""

    order: int
    """Its place among all steps of the run."""
    kind: CellUseKind
    """`call`, `message` or `goal`."""
    interface: str
    """The name of the service, topic or action."""
    content: str
    """The fields that differ from their defaults, as short text."""
    succeeded: bool = True
    """Whether it was answered with success; messages have no answer."""


@dataclass(frozen=True, slots=True)
class CellCount:
    """How often an interface of the cell was used."""

    interface: str
    """The name of the service, topic or action."""
    kind: CellUseKind
    """`call`, `message` or `goal`."""
    uses: int
    """The number of uses."""
    succeeded: int
    """The number of uses that were answered with success; messages count as such."""


Step = Rest | GripperUse | CellUse
"""Something that a run did; all of them in order are its way."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What one run brought about."""

    arms: tuple[Arm, ...] = ()
    """Each arm that was commanded."""
    objects: tuple[ObjectOutcome, ...] = ()
    """Every object that can be moved, by name."""
    rests: tuple[Rest, ...] = ()
    """The rests of the arms, in order; one after the other is never the same."""
    grips: tuple[GripperUse, ...] = ()
    """The commands to grippers, in order; one after the other is never the same."""
    cell: tuple[CellUse, ...] = ()
    """The calls, messages and goals to anything but the arm, in order."""
    streams: tuple[str, ...] = ()
    """Topics on which messages went out at a steady rate, which are not counted, sorted."""
    corner_m: float = CORNER_M
    """How far a way may lie from the lines between its corners, [m]; 0: none are kept."""
    left_out: int = 0
    """How many steps before the last rests were left out to keep the lock short."""
    counts: tuple[CellCount, ...] = ()
    """How often the cell was used in all, where steps were left out."""

    @property
    def steps(self) -> tuple[Step, ...]:
        """The rests, grips and uses of the cell, in order."""
        rests: list[Step] = [*self.rests, *self.grips, *self.cell]
        return tuple(sorted(rests, key=lambda step: step.order))

    def rests_of(self, arm: int) -> tuple[Rest, ...]:
        """Return the rests of one arm, in order."""
        return tuple(rest for rest in self.rests if rest.arm == arm)

    @property
    def under_way_s(self) -> float | None:
        """How long the only arm moves and rests until it is in its last rest [s].

        `None` where there are several, or not all rests are kept.
        """
        if len(self.arms) != 1 or self.left_out:
            return None
        times = [rest.took_s + rest.held_s for rest in self.rests]
        return sum(times) - self.rests[-1].held_s if times else 0.0

    @property
    def cell_counts(self) -> tuple[CellCount, ...]:
        """How often each interface of the cell was used, by name."""
        if self.left_out:
            return self.counts
        cell_uses: dict[str, list[CellUse]] = {}
        for use in self.cell:
            cell_uses.setdefault(use.interface, []).append(use)
        return tuple(
            CellCount(name, uses[0].kind, len(uses), sum(use.succeeded for use in uses))
            for name, uses in sorted(cell_uses.items())
        )

    @property
    def moved(self) -> tuple[ObjectOutcome, ...]:
        """The objects that ended elsewhere than they began, or are held."""
        return tuple(
            object_outcome
            for object_outcome in self.objects
            if object_outcome.held_in
            or math.dist(object_outcome.begin_m, object_outcome.end_m) > MOVED_M
        )


MOVED_M = 0.005
"""An object moved that ends further from its beginning: by less it settles, [m]."""


def moved_line(outcome: Outcome | None) -> str:
    """Return in one line which objects moved; empty where there is none that could."""
    if outcome is None or not outcome.objects:
        return ""
    moved = outcome.moved
    if not moved:
        number = len(outcome.objects)
        return f"none of {number} object{'' if number == 1 else 's'} moved"
    parts = [_moved_words(object_outcome) for object_outcome in moved[:_LISTED]]
    more = f", and {len(moved) - _LISTED} more" if len(moved) > _LISTED else ""
    plural = "object" if len(moved) == 1 else "objects"
    return f"{len(moved)} {plural} moved: {', '.join(parts)}{more}"


_LISTED = 3


def _moved_words(found: ObjectOutcome) -> str:
    if found.held_in:
        return f"{found.name} is held in {found.held_in}"
    where = f" on {found.rests_on}" if found.rests_on else ""
    x, y, z = found.end_m
    return f"{found.name} to ({x:.3f}, {y:.3f}, {z:.3f}) m{where}"
