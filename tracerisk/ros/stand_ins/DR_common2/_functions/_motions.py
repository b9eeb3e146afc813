"""Motions: by joints [deg], along lines, circles and splines [mm, deg], and by themselves."""

from __future__ import annotations

from typing import Any

from DR_common2 import get_posj, get_posx, posj

from tracerisk.ros.imports.exported import defined as _defined

from ._box import (
    DEFAULTS,
    DR_BASE,
    DR_TC_USER_MAX,
    DR_TOOL,
    done,
    duration,
    first,
    frame,
    numbers,
    rates,
    rows,
    whole,
    wrong_value,
)

DR_MV_MOD_ABS, DR_MV_MOD_REL = 0, 1
DR_MV_RA_DUPLICATE, DR_MV_RA_OVERRIDE = 0, 1
DR_MVS_VEL_NONE, DR_MVS_VEL_CONST = 0, 1
DR_AXIS_Z = 2
DR_HOME_TARGET_MECHANIC, DR_HOME_TARGET_USER = 0, 1


def _timed(vel: Any, acc: Any, time: Any, *, is_joint: bool) -> dict[str, Any]:
    """Return the fields of speed, acceleration and time; without a time both speeds are needed."""
    velocity = rates(vel, DEFAULTS.velj if is_joint else DEFAULTS.velx, "vel, v")
    acceleration = rates(acc, DEFAULTS.accj if is_joint else DEFAULTS.accx, "acc, a")
    seconds = duration(time, "time, t")
    if seconds == 0.0:
        for values, name in ((velocity, "vel, v"), (acceleration, "acc, a")):
            if not any(values) if is_joint else values[0] <= 0:
                raise wrong_value(f"{name} (0.0, when time = 0.0)")
    return {"vel": velocity, "acc": acceleration, "time": seconds}


def _how(mod: Any, ra: Any, radius: Any, is_async: bool) -> dict[str, Any]:
    return {
        "mode": whole(mod, "mod", DR_MV_MOD_ABS, DR_MV_MOD_REL),
        "blend_type": whole(ra, "ra", DR_MV_RA_DUPLICATE, DR_MV_RA_OVERRIDE),
        "radius": 0.0 if is_async else duration(radius, "radius, r"),
        "sync_type": int(is_async),
    }


def _one(fields: dict[str, Any]) -> dict[str, Any]:
    """Return fields with the first speed alone, as the service takes it."""
    return {**fields, "vel": fields["vel"][0], "acc": fields["acc"][0]}


def movej(
    pos: Any,
    vel: Any = None,
    acc: Any = None,
    time: Any = None,
    radius: Any = None,
    mod: int = DR_MV_MOD_ABS,
    ra: int = DR_MV_RA_DUPLICATE,
    v: Any = None,
    a: Any = None,
    t: Any = None,
    r: Any = None,
    _async: bool = False,
) -> int:
    """Move the joints to positions, or by them; return 0 once there, -1 where refused."""
    goal = get_posj(pos)
    timed = _timed(first(vel, v), first(acc, a), first(time, t), is_joint=True)
    how = _how(mod, ra, first(radius, r), _async)
    return done("MoveJoint", "motion/move_joint", pos=numbers(goal), **_one(timed), **how)


def movejx(
    pos: Any,
    vel: Any = None,
    acc: Any = None,
    time: Any = None,
    radius: Any = None,
    ref: Any = None,
    mod: int = DR_MV_MOD_ABS,
    ra: int = DR_MV_RA_DUPLICATE,
    sol: int = 0,
    v: Any = None,
    a: Any = None,
    t: Any = None,
    r: Any = None,
    _async: bool = False,
) -> int:
    """Move by the joints to a pose; see `movej`."""
    goal = get_posx(pos)
    timed = _timed(first(vel, v), first(acc, a), first(time, t), is_joint=True)
    how = _how(mod, ra, first(radius, r), _async)
    where = {"ref": frame(ref), "sol": whole(sol, "sol", 0, 7)}
    return done(
        "MoveJointx", "motion/move_jointx", pos=numbers(goal), **_one(timed), **how, **where
    )


def movel(
    pos: Any,
    vel: Any = None,
    acc: Any = None,
    time: Any = None,
    radius: Any = None,
    ref: Any = None,
    mod: int = DR_MV_MOD_ABS,
    ra: int = DR_MV_RA_DUPLICATE,
    v: Any = None,
    a: Any = None,
    t: Any = None,
    r: Any = None,
    app_type: int = 0,
    _async: bool = False,
) -> int:
    """Move the tool along a line; see `movej`."""
    goal = pos if type(pos) is posj else get_posx(pos)
    timed = _timed(first(vel, v), first(acc, a), first(time, t), is_joint=False)
    how = _how(mod, ra, first(radius, r), _async)
    return done("MoveLine", "motion/move_line", pos=numbers(goal), ref=frame(ref), **timed, **how)


def movec(
    pos1: Any,
    pos2: Any,
    vel: Any = None,
    acc: Any = None,
    time: Any = None,
    radius: Any = None,
    ref: Any = None,
    mod: int = DR_MV_MOD_ABS,
    angle: Any = None,
    ra: int = DR_MV_RA_DUPLICATE,
    v: Any = None,
    a: Any = None,
    t: Any = None,
    r: Any = None,
    an: Any = None,
    ori: int = 0,
    app_type: int = 0,
    _async: bool = False,
) -> int:
    """Move the tool along a circle over one pose to another; see `movej`."""
    goals = rows([get_posx(pos1), get_posx(pos2)])
    timed = _timed(first(vel, v), first(acc, a), first(time, t), is_joint=False)
    how = _how(mod, ra, first(radius, r), _async)
    asked_angle = first(angle, an)
    one, other = asked_angle if type(asked_angle) is list else (asked_angle or 0, 0)
    turn = {"angle1": duration(one, "angle, an"), "angle2": duration(other, "angle, an")}
    return done(
        "MoveCircle", "motion/move_circle", pos=goals, ref=frame(ref), **timed, **how, **turn
    )


def movesj(
    pos_list: Any,
    vel: Any = None,
    acc: Any = None,
    time: Any = None,
    mod: int = DR_MV_MOD_ABS,
    v: Any = None,
    a: Any = None,
    t: Any = None,
    _async: bool = False,
) -> int:
    """Move the joints through positions; see `movej`."""
    points = rows(get_posj(item) for item in pos_list)
    timed = _timed(first(vel, v), first(acc, a), first(time, t), is_joint=True)
    mode = whole(mod, "mod", DR_MV_MOD_ABS, DR_MV_MOD_REL)
    how = {"pos_cnt": len(points), "mode": mode, "sync_type": int(_async)}
    return done("MoveSplineJoint", "motion/move_spline_joint", pos=points, **timed, **how)


def movesx(
    pos_list: Any,
    vel: Any = None,
    acc: Any = None,
    time: Any = None,
    ref: Any = None,
    mod: int = DR_MV_MOD_ABS,
    vel_opt: int = DR_MVS_VEL_NONE,
    v: Any = None,
    a: Any = None,
    t: Any = None,
    _async: bool = False,
) -> int:
    """Move the tool through poses; see `movej`."""
    points = rows(get_posx(item) for item in pos_list)
    timed = _timed(first(vel, v), first(acc, a), first(time, t), is_joint=False)
    mode = whole(mod, "mod", DR_MV_MOD_ABS, DR_MV_MOD_REL)
    how = {"pos_cnt": len(points), "mode": mode, "sync_type": int(_async)}
    option = whole(vel_opt, "vel_opt", DR_MVS_VEL_NONE, DR_MVS_VEL_CONST)
    return done(
        "MoveSplineTask",
        "motion/move_spline_task",
        pos=points,
        ref=frame(ref),
        opt=option,
        **timed,
        **how,
    )


def moveb(
    seg_list: Any,
    vel: Any = None,
    acc: Any = None,
    ref: Any = None,
    time: Any = None,
    mod: int = DR_MV_MOD_ABS,
    v: Any = None,
    a: Any = None,
    t: Any = None,
    _async: bool = False,
) -> int:
    """Move the tool along segments (`posb`); see `movej`."""
    made = []
    for segment in seg_list:
        kind, one, other, radius = segment.to_list()
        made.append([*one, *(one if other is None else other), kind, radius])
    timed = _timed(first(vel, v), first(acc, a), first(time, t), is_joint=False)
    mode = whole(mod, "mod", DR_MV_MOD_ABS, DR_MV_MOD_REL)
    how = {"pos_cnt": len(made), "mode": mode, "sync_type": int(_async)}
    return done(
        "MoveBlending",
        "motion/move_blending",
        segment=rows(made),
        ref=frame(ref),
        **timed,
        **how,
    )


def move_spiral(
    rev: float = 10,
    rmax: float = 10,
    lmax: float = 0,
    vel: Any = None,
    acc: Any = None,
    time: Any = None,
    axis: int = DR_AXIS_Z,
    ref: int = DR_TOOL,
    v: Any = None,
    a: Any = None,
    t: Any = None,
    _async: bool = False,
) -> int:
    """Move the tool along a spiral; see `movej`."""
    timed = _timed(first(vel, v), first(acc, a), first(time, t), is_joint=False)
    return done(
        "MoveSpiral",
        "motion/move_spiral",
        revolution=float(rev),
        max_radius=float(rmax),
        max_length=float(lmax),
        task_axis=whole(axis, "axis", 0, DR_AXIS_Z),
        ref=whole(ref, "ref", DR_BASE, DR_TC_USER_MAX),
        sync_type=int(_async),
        **timed,
    )


def move_periodic(
    amp: Any,
    period: Any,
    atime: Any = None,
    repeat: Any = None,
    ref: Any = DR_TOOL,
    _async: bool = False,
) -> int:
    """Move the tool to and fro along each axis; see `movej`."""
    if type(amp) is not list or len(amp) != 6:
        raise wrong_value("amp")
    each = list(period) if isinstance(period, list) else [period] * 6
    if len(each) != 6:
        raise wrong_value("period")
    return done(
        "MovePeriodic",
        "motion/move_periodic",
        amp=numbers(amp),
        periodic=numbers(each),
        acc=duration(atime, "atime"),
        repeat=int(1 if repeat is None else duration(repeat, "repeat")),
        ref=whole(DR_TOOL if ref is None else ref, "ref", DR_BASE, DR_TC_USER_MAX),
        sync_type=int(_async),
    )


def _without_waiting(move: Any) -> Any:
    def begin(*values: Any, **named: Any) -> int:
        code: int = move(*values, **named, _async=True)
        return code

    begin.__name__, begin.__doc__ = f"a{move.__name__}", f"Begin {move.__name__}; do not wait."
    return begin


amovej, amovejx, amovel = map(_without_waiting, (movej, movejx, movel))
amovec, amovesj, amovesx = map(_without_waiting, (movec, movesj, movesx))
amoveb, amove_spiral = map(_without_waiting, (moveb, move_spiral))
amove_periodic = _without_waiting(move_periodic)


def move_home(target: Any = None) -> int:
    """Move to the home position."""
    home = DR_HOME_TARGET_MECHANIC if target is None else target
    return done("MoveHome", "motion/move_home", target=home)


def mwait(time: Any = 0) -> int:
    """Wait for the end of the motion that was begun."""
    duration(time, "time")
    return done("MoveWait", "motion/move_wait")


def stop(st_mode: int) -> int:
    """Stop the motion."""
    return done("MoveStop", "motion/move_stop", stop_mode=whole(st_mode, "st_mode", 0, 3))


def jog(jog_axis: int, ref: int = 0, speed: float = 0) -> int:
    """Move a joint or along an axis at a share of the speed [%]; 0 stops it."""
    return done("Jog", "motion/jog", jog_axis=jog_axis, move_reference=ref, speed=float(speed))


__all__ = _defined(
    globals(),
    *("DR_MV_MOD_ABS", "DR_MV_MOD_REL", "DR_MV_RA_DUPLICATE", "DR_MV_RA_OVERRIDE"),
    *("DR_MVS_VEL_NONE", "DR_MVS_VEL_CONST", "DR_AXIS_Z"),
    *("DR_HOME_TARGET_MECHANIC", "DR_HOME_TARGET_USER"),
)
