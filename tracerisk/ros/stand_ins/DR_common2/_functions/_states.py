"""What the controller reports and keeps: positions, modes, pins, programs."""

from __future__ import annotations

import time as _time
from typing import Any

from DR_common2 import get_posj, get_posx, posj, posx

from tracerisk.ros.imports.exported import defined as _defined

from ._box import (
    DEFAULTS,
    DR_BASE,
    DR_COND_NONE,
    DR_TC_USER_MAX,
    asked,
    done,
    frame,
    numbers,
    rates,
    whole,
    wrong_value,
)

DR_AVOID, DR_TASK_STOP, DR_VAR_VEL = 0, 1, 2
ON, OFF = 1, 0
_PINS, _TOOL_PINS = 16, 6


def wait(second: float) -> None:
    """Wait for some seconds."""
    _time.sleep(second)


# Defaults of later motions


def set_velj(vel: Any) -> int:
    """Set the speed of the joints [deg/s]."""
    DEFAULTS.velj = _set(vel, DEFAULTS.velj, "vel")
    return 0


def set_accj(acc: Any) -> int:
    """Set the acceleration of the joints [deg/s^2]."""
    DEFAULTS.accj = _set(acc, DEFAULTS.accj, "acc")
    return 0


def set_velx(vel1: Any, vel2: Any = DR_COND_NONE) -> int:
    """Set the speed of the tool [mm/s], and of its turns [deg/s]."""
    DEFAULTS.velx = _set([vel1, vel2], DEFAULTS.velx, "vel")
    return 0


def set_accx(acc1: Any, acc2: Any = DR_COND_NONE) -> int:
    """Set the acceleration of the tool [mm/s^2], and of its turns [deg/s^2]."""
    DEFAULTS.accx = _set([acc1, acc2], DEFAULTS.accx, "acc")
    return 0


def _set(given: Any, default: list[float], name: str) -> list[float]:
    made = rates(given, default, name)
    if any(value <= 0 and value != DR_COND_NONE for value in made):
        raise wrong_value(name)
    return made


def set_ref_coord(coord: int) -> int:
    """Set the frame of motions that name none."""
    code = done(
        "SetRefCoord", "motion/set_ref_coord", coord=whole(coord, "coord", 0, DR_TC_USER_MAX)
    )
    DEFAULTS.coord = coord
    return code


def change_operation_speed(speed: int) -> int:
    """Set the share of all speeds [%]."""
    share = whole(speed, "speed", 1, 100)
    return done("ChangeOperationSpeed", "motion/change_operation_speed", speed=share)


def set_singularity_handling(mode: int = DR_AVOID) -> int:
    """Set what happens near singularities."""
    return done("SetSingularityHandling", "motion/set_singularity_handling", mode=mode)


set_singular_handling = set_singularity_handling

# Modes and states


def set_robot_mode(robot_mode: int) -> int:
    """Set the mode: manual, autonomous or measure."""
    mode = whole(robot_mode, "robot_mode", 0, 2)
    return done("SetRobotMode", "system/set_robot_mode", robot_mode=mode)


def get_robot_mode() -> int:
    """Return the mode."""
    return int(asked("GetRobotMode", "system/get_robot_mode").robot_mode)


def set_robot_system(robot_system: int) -> int:
    """Set whether the robot is a real or a virtual one."""
    kind = whole(robot_system, "robot_system", 0, 1)
    return done("SetRobotSystem", "system/set_robot_system", robot_system=kind)


def get_robot_system() -> int:
    """Return whether the robot is a real or a virtual one."""
    return int(asked("GetRobotSystem", "system/get_robot_system").robot_system)


def get_robot_state() -> int:
    """Return the state: 1 at rest, 2 in motion."""
    return int(asked("GetRobotState", "system/get_robot_state").robot_state)


def set_robot_speed_mode(speed_mode: int) -> int:
    """Set the normal or the reduced speed."""
    mode = whole(speed_mode, "speed_mode", 0, 1)
    return done("SetRobotSpeedMode", "system/set_robot_speed_mode", speed_mode=mode)


def get_robot_speed_mode() -> int:
    """Return whether the speed is reduced."""
    return int(asked("GetRobotSpeedMode", "system/get_robot_speed_mode").speed_mode)


def set_safe_stop_reset_type(reset_type: int) -> int:
    """Set what follows a safe stop."""
    return done("SetSafeStopResetType", "system/set_safe_stop_reset_type", reset_type=reset_type)


def get_last_alarm() -> Any:
    """Return the last alarm."""
    return asked("GetLastAlarm", "system/get_last_alarm").log_alarm


def check_motion() -> int:
    """Return 0 at rest, 2 in motion."""
    return int(asked("CheckMotion", "motion/check_motion").status)


def get_control_mode() -> int:
    """Return whether positions or torques are controlled."""
    return int(asked("GetControlMode", "aux_control/get_control_mode").control_mode)


# Where it is


def get_current_posj() -> Any:
    """Return the positions of the joints [deg]."""
    return posj(list(asked("GetCurrentPosj", "aux_control/get_current_posj").pos))


def get_desired_posj() -> Any:
    """Return the positions that the joints are to have [deg]."""
    return posj(list(asked("GetDesiredPosj", "aux_control/get_desired_posj").pos))


def get_current_velj() -> list[float]:
    """Return the speeds of the joints [deg/s]."""
    return list(asked("GetCurrentVelj", "aux_control/get_current_velj").joint_speed)


def get_current_posx(ref: Any = None) -> tuple[Any, int]:
    """Return the pose of the tool [mm, deg], and its solution space."""
    answer = asked("GetCurrentPosx", "aux_control/get_current_posx", ref=frame(ref))
    values = list(answer.task_pos_info[0].data)
    return posx(values[:6]), round(values[6])


def get_desired_posx(ref: Any = None) -> Any:
    """Return the pose that the tool is to have [mm, deg]."""
    return posx(list(asked("GetDesiredPosx", "aux_control/get_desired_posx", ref=frame(ref)).pos))


def get_current_tool_flange_posx(ref: Any = None) -> Any:
    """Return the pose of the flange [mm, deg]."""
    where = DR_BASE if ref is None else ref
    name = "aux_control/get_current_tool_flange_posx"
    return posx(list(asked("GetCurrentToolFlangePosx", name, ref=where).pos))


def get_current_pose(space_type: int) -> list[float]:
    """Return where the joints (0) or the tool (1) are."""
    kind = whole(space_type, "space_type", 0, 1)
    return list(asked("GetCurrentPose", "system/get_current_pose", space_type=kind).pos)


def get_current_rotm(ref: Any = None) -> list[list[float]]:
    """Return the turn of the tool as a matrix."""
    answer = asked("GetCurrentRotm", "aux_control/get_current_rotm", ref=frame(ref))
    return [list(row.data) for row in answer.rot_matrix]


def get_current_solution_space() -> int:
    """Return the solution space."""
    name = "aux_control/get_current_solution_space"
    return int(asked("GetCurrentSolutionSpace", name).sol_space)


def get_joint_torque() -> list[float]:
    """Return the torques of the joints [N m]."""
    return list(asked("GetJointTorque", "aux_control/get_joint_torque").jts)


def get_external_torque() -> list[float]:
    """Return the torques on the joints from outside [N m]."""
    return list(asked("GetExternalTorque", "aux_control/get_external_torque").ext_torque)


def get_tool_force(ref: Any = None) -> list[float]:
    """Return force and torque at the tool [N, N m]."""
    where = DR_BASE if ref is None else ref
    return list(asked("GetToolForce", "aux_control/get_tool_force", ref=where).tool_force)


def fkin(pos: Any, ref: Any = None) -> Any:
    """Return the pose at positions of the joints."""
    where = DR_BASE if ref is None else ref
    return asked("Fkin", "motion/fkin", pos=numbers(get_posj(pos)), ref=where).conv_posx


def ikin(pos: Any, sol_space: int, ref: Any = None) -> Any:
    """Return positions of the joints that lead to a pose."""
    fields = {"sol_space": whole(sol_space, "sol_space", 0, 7), "ref": ref or DR_BASE}
    return asked("Ikin", "motion/ikin", pos=numbers(get_posx(pos)), **fields).conv_posj


def trans(pos: Any, delta: Any, ref: Any = None, ref_out: int = DR_BASE) -> Any:
    """Return a pose moved and turned by another one."""
    return asked(
        "Trans",
        "motion/trans",
        pos=numbers(get_posx(pos)),
        delta=numbers(get_posx(delta)),
        ref=frame(ref),
        ref_out=ref_out,
    ).trans_pos


# Pins


def _switched(index: Any, val: Any, most: int) -> tuple[int, int]:
    """Return a pin and its value; without a value the sign of the pin says it."""
    whole(index, "index")
    if val is None:
        index, val = abs(index), ON if index > 0 else OFF
    return whole(index, "index", 1, most), whole(val, "val", OFF, ON)


def set_digital_output(index: int, val: Any = None) -> int:
    """Switch an output of the controller."""
    pin, value = _switched(index, val, _PINS)
    name = "io/set_ctrl_box_digital_output"
    return done("SetCtrlBoxDigitalOutput", name, index=pin, value=value)


def get_digital_output(index: int) -> int:
    """Return an output of the controller."""
    pin = whole(index, "index", 1, _PINS)
    answer = asked("GetCtrlBoxDigitalOutput", "io/get_ctrl_box_digital_output", index=pin)
    return int(answer.value)


def get_digital_input(index: int) -> int:
    """Return an input of the controller."""
    pin = whole(index, "index", 1, _PINS)
    answer = asked("GetCtrlBoxDigitalInput", "io/get_ctrl_box_digital_input", index=pin)
    return int(answer.value)


def set_tool_digital_output(index: int, val: Any = None) -> int:
    """Switch an output of the flange."""
    pin, value = _switched(index, val, _TOOL_PINS)
    return done("SetToolDigitalOutput", "io/set_tool_digital_output", index=pin, value=value)


def get_tool_digital_input(index: int) -> int:
    """Return an input of the flange."""
    pin = whole(index, "index", 1, _TOOL_PINS)
    return int(asked("GetToolDigitalInput", "io/get_tool_digital_input", index=pin).value)


def get_tool_digital_output(index: int) -> int:
    """Return an output of the flange."""
    pin = whole(index, "index", 1, _TOOL_PINS)
    return int(asked("GetToolDigitalOutput", "io/get_tool_digital_output", index=pin).value)


def get_analog_input(ch: int) -> float:
    """Return an analog input of the controller."""
    channel = whole(ch, "ch", 1, 2)
    name = "io/get_ctrl_box_analog_input"
    return float(asked("GetCtrlBoxAnalogInput", name, channel=channel).value)


def set_analog_output(ch: int, val: float) -> int:
    """Set an analog output of the controller."""
    channel, name = whole(ch, "ch", 1, 2), "io/set_ctrl_box_analog_output"
    return done("SetCtrlBoxAnalogOutput", name, channel=channel, value=float(val))


# Programs


def drl_script_run(robotSystem: int, code: str) -> int:
    """Run a program of the controller's own language."""
    return done("DrlStart", "drl/drl_start", robot_system=robotSystem, code=code)


def drl_script_stop(stop_mode: int) -> int:
    """Stop a program."""
    return done("DrlStop", "drl/drl_stop", stop_mode=stop_mode)


def drl_script_pause() -> int:
    """Pause a program."""
    return done("DrlPause", "drl/drl_pause")


def drl_script_resume() -> int:
    """Go on with a program."""
    return done("DrlResume", "drl/drl_resume")


def get_drl_state() -> int:
    """Return whether a program runs (0), was stopped (1) or is held (2)."""
    return int(asked("GetDrlState", "drl/get_drl_state").drl_state)


__all__ = _defined(
    globals(),
    *("DR_AVOID", "DR_TASK_STOP", "DR_VAR_VEL", "ON", "OFF"),
    "set_singular_handling",
)
