"""What counts as the same: steps, rests and contents of two missions, within tolerances."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.common.outcome.arm import angle_between
from tracerisk.common.outcome.outcome import CellUse, GripperUse, Rest, Step

if TYPE_CHECKING:
    from tracerisk.config import Settings

ROUNDING = 1.0001
"""Of a tolerance: figures are kept in whole steps."""
OPENING = 0.1
"""Of a gripper's range: by how much openings may differ that are the same."""
_FIGURE_SHARE, _FIGURE_LEAST = 0.01, 0.002  # how far figures of a message may differ
_FIGURE = re.compile(r"(?<![\w'])-?(?:\d+\.\d+(?:e[+-]?\d+)?|\d+e[+-]?\d+)(?![\w'])")


@dataclass(frozen=True, slots=True)
class Tolerances:
    """By how much two outcomes may differ and count as the same."""

    place_m: float = 0.002
    """Of objects and of the tool at rest, [m]."""
    angle_deg: float = 2.0
    """Of an object's tilt and heading, [deg]."""
    joint: float = 0.005
    """Of a joint at rest, [rad or m]."""

    @classmethod
    def of(cls, settings: Settings) -> Tolerances:
        """Return those of the settings."""
        return cls(
            settings.outcome_place_mm / 1000.0,
            settings.outcome_angle_deg,
            settings.outcome_joint_mrad / 1000.0,
        )

    def is_same_posture(self, old: Rest, new: Rest) -> bool:
        """Return whether the joints rest at the same positions."""
        return _is_alike(old, new, self.joint)

    def is_same(self, old: Step, new: Step) -> bool:
        """Return whether two steps of a mission are the same."""
        if isinstance(old, Rest) and isinstance(new, Rest):
            return self.is_same_rest(old, new)
        if isinstance(old, GripperUse) and isinstance(new, GripperUse):
            is_as_open = bool(old.holds) or abs(old.opened - new.opened) <= OPENING
            return old.gripper == new.gripper and old.holds == new.holds and is_as_open
        if isinstance(old, CellUse) and isinstance(new, CellUse):
            is_alike = (old.kind, old.interface, old.succeeded) == (
                new.kind,
                new.interface,
                new.succeeded,
            )
            return is_alike and is_same_content(old.content, new.content)
        return False

    def is_same_rest(self, old: Rest, new: Rest, times: float = 1.0) -> bool:
        """Return whether the tool rests at the same place, within some times the tolerances."""
        if old.arm != new.arm or len(old.joints) != len(new.joints):
            return False
        if _is_alike(old, new, times * self.joint):
            return True
        is_near = math.dist(old.tool_m, new.tool_m) <= times * self.place_m * ROUNDING
        turned = math.degrees(angle_between(old.tool_turn, new.tool_turn))
        return is_near and turned <= times * self.angle_deg * ROUNDING


TOLERANCES = Tolerances()


def _is_alike(old: Rest, new: Rest, limit: float) -> bool:
    joints = zip(old.joints, new.joints, strict=True)
    return all(abs(one - other) <= limit * ROUNDING for one, other in joints)


def is_same_content(one: str, other: str) -> bool:
    """Return whether two contents say the same: whole numbers exactly, others within 1 %."""
    if one == other:
        return True
    if _FIGURE.sub("#", one) != _FIGURE.sub("#", other):
        return False
    figures = zip(_FIGURE.findall(one), _FIGURE.findall(other), strict=True)
    return all(
        math.isclose(float(a), float(b), rel_tol=_FIGURE_SHARE, abs_tol=_FIGURE_LEAST)
        for a, b in figures
    )
