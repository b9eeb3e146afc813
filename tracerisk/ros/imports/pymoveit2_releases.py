"""What programs ask of pymoveit2 that the release of the package index does not have.

`pymoveit2.robots.NAME` of a robot that only forks of the library have has the names of the twin's
robot. Release 5 took away arguments and a method that all releases before it had; what stood for
them in release 4 does so here. The run says both.
"""

from __future__ import annotations

import contextlib
import functools
import inspect
import sys
import sysconfig
from collections.abc import Callable, Iterator
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.imports.cfg_modules import FilledLoader
from tracerisk.ros.imports.once_loaded import once_loaded
from tracerisk.twin.robots.gripper_ends import gripper_ends
from tracerisk.twin.robots.robot import Robot

_PARENT = "pymoveit2.robots"
# AndrejOrsula/pymoveit2 4.2.0, pymoveit2/moveit2.py: what each argument of older releases became;
# None where that release ignores it.
_OLDER: dict[tuple[str, str], dict[str, str | None]] = {
    **{
        (owner, "__init__"): {
            "execute_via_moveit": "use_move_group_action",
            "follow_joint_trajectory_action_name": None,
        }
        for owner in ("MoveIt2", "MoveIt2Gripper", "GripperInterface")
    },
    ("MoveIt2", "plan"): {"max_step": "cartesian_max_step"},
    ("MoveIt2", "plan_async"): {"max_step": "cartesian_max_step"},
    ("MoveIt2", "reset_controller"): {"sync": None},
}
_RENAMED = {"remove_collision_mesh": "remove_collision_object"}


def robot_of_a_fork(fullname: str) -> ModuleSpec | None:
    """Return the spec of the module of a robot; None for all else, and in an author's own fork."""
    parent, _, name = fullname.rpartition(".")
    if parent != _PARENT or name.startswith("_"):
        return None
    if not Path(str(sys.modules[parent].__file__)).is_relative_to(sysconfig.get_path("purelib")):
        return None
    return ModuleSpec(fullname, FilledLoader(lambda _: _names(name)))


def _names(module: str) -> dict[str, Any]:
    robot = current().twin.robot
    current().recorder.finding(
        "unprovided",
        f"pymoveit2.robots has no '{module}', which a fork of the library may have: the names of "
        f"its joints, links and groups are those of {robot.name}; put the fork's sources into the "
        "workspace",
        asking_place(),
    )
    return names_of(robot)


def names_of(robot: Robot) -> dict[str, Any]:
    """Return what a module of AndrejOrsula/pymoveit2 pymoveit2/robots holds, for a robot."""
    held = {joint for gripper in robot.grippers for joint in gripper.joints}
    arm = max(robot.groups, key=lambda group: len({*robot.groups[group].joints} - held))
    joints = [joint for joint in robot.groups[arm].joints if joint not in held]
    tip = robot.groups[arm].tip_link or robot.links[-1].name
    names: dict[str, Any] = {
        "MOVE_GROUP_ARM": arm,
        "MOVE_GROUP_GRIPPER": "gripper",
        "OPEN_GRIPPER_JOINT_POSITIONS": [],
        "CLOSED_GRIPPER_JOINT_POSITIONS": [],
    }
    fingers: list[str] = []
    if robot.grippers:
        gripper = robot.grippers[0]
        ends, fingers = gripper_ends(robot, gripper), list(gripper.joints)
        names["MOVE_GROUP_GRIPPER"] = gripper.group
        names["OPEN_GRIPPER_JOINT_POSITIONS"] = [sign * ends.opened for sign in gripper.signs]
        names["CLOSED_GRIPPER_JOINT_POSITIONS"] = [sign * ends.closed for sign in gripper.signs]
    return {
        **names,
        "joint_names": lambda *_, **__: list(joints),
        "base_link_name": lambda *_, **__: robot.base_link,
        "end_effector_name": lambda *_, **__: tip,
        "gripper_joint_names": lambda *_, **__: list(fingers),
    }


@contextlib.contextmanager
def served_older_releases() -> Iterator[None]:
    """Serve what programs of older releases ask of the library, with a note."""
    with contextlib.ExitStack() as undo:
        undo.enter_context(once_loaded("pymoveit2", functools.partial(_serve, undo)))
        yield


def _serve(undo: contextlib.ExitStack, library: ModuleType) -> None:
    for (owner, method), arguments in _OLDER.items():
        class_ = vars(library).get(owner)
        function = vars(class_).get(method) if class_ is not None else None
        if function is None:
            continue
        known = inspect.signature(function).parameters
        gone = {name: now for name, now in arguments.items() if name not in known}
        if gone:
            setattr(class_, method, _taking(function, owner, gone))
            undo.callback(setattr, class_, method, function)
    moveit2 = vars(library).get("MoveIt2")
    for name, now in _RENAMED.items():
        if moveit2 is not None and not hasattr(moveit2, name) and hasattr(moveit2, now):
            setattr(moveit2, name, _noted(getattr(moveit2, now), f"MoveIt2.{name}"))
            undo.callback(delattr, moveit2, name)


def _taking(
    function: Callable[..., Any], owner: str, gone: dict[str, str | None]
) -> Callable[..., Any]:
    """Return a function that takes the arguments that are gone, as release 4 does."""

    @functools.wraps(function)
    def taking(*given: Any, **named: Any) -> Any:
        for name in sorted(gone.keys() & named.keys()):
            value, now = named.pop(name), gone[name]
            _note(f"{owner}({name}=)")
            if now is not None and value:
                named[now] = value
        return function(*given, **named)

    return taking


def _noted(function: Callable[..., Any], name: str) -> Callable[..., Any]:
    @functools.wraps(function)
    def noted(*given: Any, **named: Any) -> Any:
        _note(name)
        return function(*given, **named)

    return noted


def _note(name: str) -> None:
    current().recorder.finding(
        "removed_name",
        f"{name} is gone from the release of pymoveit2 that runs; it is taken as release 4 of the "
        "library takes it",
        asking_place(),
        object_name=name,
    )
