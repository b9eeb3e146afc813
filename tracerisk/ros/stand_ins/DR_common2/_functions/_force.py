"""What the controller does with forces: compliance, desired forces, conditions."""

from __future__ import annotations

from typing import Any

from DR_common2 import get_normal_pos, posx

from tracerisk.ros.imports.exported import defined as _defined

from ._box import (
    DEFAULTS,
    DR_COND_NONE,
    done,
    duration,
    frame,
    numbers,
    whole,
    wrong_type,
    wrong_value,
)

DR_FC_MOD_ABS, DR_FC_MOD_REL = 0, 1


def task_compliance_ctrl(stx: Any = None, time: Any = 0) -> int:
    """Begin to give way to forces."""
    stiffness = [3000, 3000, 3000, 200, 200, 200] if stx is None else stx
    fields = {"stx": numbers(stiffness), "ref": DEFAULTS.coord, "time": _ramp(time)}
    return done("TaskComplianceCtrl", "force/task_compliance_ctrl", **fields)


def release_compliance_ctrl() -> int:
    """End giving way to forces."""
    return done("ReleaseComplianceCtrl", "force/release_compliance_ctrl")


def set_stiffnessx(stx: Any = None, time: Any = 0) -> int:
    """Set how much the tool gives way."""
    stiffness = [500, 500, 500, 100, 100, 100] if stx is None else stx
    fields = {"stx": numbers(stiffness), "ref": DEFAULTS.coord, "time": _ramp(time)}
    return done("SetStiffnessx", "force/set_stiffnessx", **fields)


def set_desired_force(
    fd: Any = (0,) * 6, dir: Any = (0,) * 6, time: Any = 0, mod: int = DR_FC_MOD_ABS
) -> int:
    """Begin to press with a force [N, N m] along the axes that `dir` names."""
    if len(fd) != 6:
        raise wrong_type("fd")
    if len(dir) != 6:
        raise wrong_type("dir")
    return done(
        "SetDesiredForce",
        "force/set_desired_force",
        fd=numbers(fd),
        dir=[int(item) for item in dir],
        ref=DEFAULTS.coord,
        time=_ramp(time),
        mod=whole(mod, "mod"),
    )


def release_force(time: Any = 0) -> int:
    """End pressing."""
    return done("ReleaseForce", "force/release_force", time=_ramp(time))


def _ramp(time: Any) -> float:
    return -1.0 if time == -1 else min(duration(time, "time"), 1.0)


def _within(axis: int, min: Any, max: Any, ref: Any) -> dict[str, Any]:
    if DR_COND_NONE not in (min, max) and min > max:
        raise wrong_value(f"min({min}), max({max})")
    if min == max == DR_COND_NONE:
        raise wrong_value(f"min({min}), max({max})")
    return {"axis": whole(axis, "axis"), "min": float(min), "max": float(max), "ref": frame(ref)}


def check_force_condition(
    axis: int, min: Any = DR_COND_NONE, max: Any = DR_COND_NONE, ref: Any = None
) -> int:
    """Return 0 where the force along an axis is within limits [N], else -1."""
    within = _within(axis, min, max, ref)
    return done("CheckForceCondition", "force/check_force_condition", **within)


def check_position_condition(
    axis: int,
    min: Any = DR_COND_NONE,
    max: Any = DR_COND_NONE,
    ref: Any = None,
    mod: int = 0,
    pos: Any = None,
) -> int:
    """Return 0 where the tool is within limits along an axis [mm], else -1."""
    within = _within(axis, min, max, ref)
    if mod == 1 and pos is None:
        raise wrong_value("need to pos")
    origin = [0.0] * 6 if pos is None else numbers(get_normal_pos(pos, def_type=posx))
    name = "force/check_position_condition"
    return done("CheckPositionCondition", name, mode=whole(mod, "mod", 0, 1), pos=origin, **within)


__all__ = _defined(globals(), "DR_FC_MOD_ABS", "DR_FC_MOD_REL")
