"""The controllers of a run and their states, as far as anything says which these are."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.ros.graph.declared_controllers import DeclaredController, DeclaredControllers
from tracerisk.ros.robot.bring_up.drivers import BringUp, bring_up_of
from tracerisk.ros.robot.bring_up.launched import LaunchedControllers

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

TYPES = {
    "follow_joint_trajectory": "JointTrajectoryController",
    "gripper_command": "GripperActionController",
}
_BROADCASTERS = {
    True: ("joint_state_broadcaster", "joint_state_broadcaster/JointStateBroadcaster"),
    False: ("joint_state_controller", "joint_state_controller/JointStateController"),
}
"""The controller that publishes joint states, and its type, by whether it is of ROS 2."""
_MODERN = "/URScript"
"""The end of the topic of ur_modern_driver for scripts."""
BROADCASTS = DeclaredController((), "JointStateBroadcaster")
_PUBLISHES = re.compile(r"joint_state_(controller|broadcaster)$")


def robot_controllers(runtime: Runtime) -> dict[str, DeclaredController]:
    """Return the controllers of the robot, and those that files of the workspace declare."""
    robot = runtime.twin.robot
    known = {
        controller.name: DeclaredController(controller.joints, TYPES[controller.type])
        for controller in robot.controllers
    }
    declared = runtime.client(DeclaredControllers)
    return known | dict(declared.of_robot(joint.name for joint in robot.joints))


class ControllerStates:
    """The controllers, and which of them run: `runtime.client(ControllerStates)`.

    Where the bring-up of the driver is known, and no file of the workspace starts the robot
    otherwise, it says which do. Else those of the robot and of the workspace's files are loaded,
    and of those for the same joints one is taken to run: one that files declare, of these MoveIt's
    default, and else one for trajectories. Nobody knows that, and a controller is known to be
    inactive once it was switched off.
    """

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._switched: set[str] = set()
        self._ended_by = ""
        self._script_topic = ""
        self._held = ""
        self.starts = 0
        """How often the program by which the driver moves the arm was started again."""

    @cached_property
    def all(self) -> dict[str, DeclaredController]:
        """The loaded controllers by their names."""
        known = robot_controllers(self._runtime)
        modes = dict(self._runtime.client(DeclaredControllers).without_joints)
        if self._bring_up is None:
            name, kind = _BROADCASTERS[self._runtime.distro.is_ros2]
            is_there = any(_PUBLISHES.search(mode) for mode in (*modes, *known))
            return modes | known | ({} if is_there else {name: DeclaredController((), kind)})
        made, robot = self._bring_up, self._runtime.twin.robot
        driven = {controller.name for controller in robot.controllers}
        joints = known[made.mark].joints
        loaded = {
            name: DeclaredController(() if name in made.idle else joints, kind)
            for name, kind in (*made.active.items(), *made.inactive.items())
        }
        others = {
            name: controller
            for name, controller in known.items()
            if name not in loaded and (name not in driven or controller.joints != joints)
        }
        return modes | loaded | others

    def load(self, name: str) -> None:
        """Load a controller: one whose parameters the driver sets, or of which nothing is known."""
        made, loaded = self._bring_up, BROADCASTS
        if made is not None and name in made.loadable:
            joints = robot_controllers(self._runtime)[made.mark].joints
            loaded = DeclaredController(joints, made.loadable[name])
        self.all.setdefault(name, loaded)

    @cached_property
    def running(self) -> set[str]:
        """The names of those that run."""
        running: list[str] = []
        made = self._bring_up
        held = set() if made is None else {*made.inactive}
        # A mode of a driver that commands no joints begins where a program asks for it.
        held |= {
            name
            for name, controller in self.all.items()
            if not controller.joints
            and "State" not in controller.type
            and "roadcaster" not in controller.type
            and (made is None or name not in made.active)
        }
        for name in sorted(self.all, key=self._rank):
            if name not in held and not self.conflicts(name, running):
                running.append(name)
        return set(running)

    def _rank(self, name: str) -> tuple[bool, bool, bool, bool]:
        """Return how late a controller is started.

        The driver's come first, then those of files, MoveIt's default, and those of trajectories.
        """
        made, controller = self._bring_up, self.all[name]
        is_drivers = made is not None and name in made.active
        is_of_files = bool(controller.settings)
        is_of_trajectories = "Trajectory" in controller.type
        return not is_drivers, not is_of_files, not controller.is_default, not is_of_trajectories

    def conflicts(self, name: str, running: Iterable[str]) -> list[str]:
        """Return the controllers of some that command joints which another one commands, too."""
        own = set(self.all[name].joints)
        return [other for other in running if own & set(self.all[other].joints)]

    def switch(self, stopped: Iterable[str], started: Iterable[str]) -> None:
        """Stop and start controllers."""
        for name in stopped:
            self.running.discard(name)
            self._switched.add(name)
        for name in started:
            self.running.add(name)
            self._switched.add(name)
            if self._script_topic.endswith(_MODERN) and self.all[name].joints:
                self.program_started()

    def script_came(self, topic: str) -> None:
        """Note that a script on a topic has ended the program by which the driver moves the arm."""
        self._script_topic = topic
        self._ended_by = f"the script that came on {topic}"

    def program_stopped(self, service: str) -> None:
        """Note that a service has ended the program by which the driver moves the arm."""
        self._script_topic, self._ended_by = "", f"service {service}"

    def program_started(self) -> None:
        """Note that the program by which the driver moves the arm runs again."""
        self._script_topic = self._ended_by = ""
        self.starts += 1

    def hold(self, words: str) -> None:
        """Note why the driver carries out no trajectories of the arm; empty where it does."""
        self._held = words

    def lost_arm(self, interface: str) -> str:
        """Return why the controller of an action takes goals and moves nothing; empty if it does.

        ur_modern_driver leaves its controllers running where a script has ended its program, and a
        driver of which the mode was changed knows nothing of them.
        """
        if self._held and self._arm.intersection(self._joints(interface)):
            return self._held
        is_modern = self._script_topic.endswith(_MODERN)
        return self.without_program(self._joints(interface)) if is_modern else ""

    def without_program(self, joints: Iterable[str]) -> str:
        """Return why the driver moves none of some joints of the arm; empty where it does."""
        if not self._arm.intersection(joints):
            return ""
        if self._held or not self._ended_by:
            return self._held
        again = (
            "stop and start the controller with service switch_controller"
            if self._script_topic.endswith(_MODERN)
            else "start it with service resend_robot_program, or play of the dashboard"
        )
        wrap = ", or wrap a script that moves nothing in `sec`" if self._script_topic else ""
        return (
            f"{self._ended_by} ended the program by which the driver moves the arm; {again}{wrap}"
        )

    @property
    def _arm(self) -> frozenset[str]:
        return frozenset(joint.name for joint in self._runtime.twin.robot.arm_joints)

    def _joints(self, interface: str) -> Iterable[str]:
        """Return the joints of the controller of an interface; of the arm if it is not known."""
        name = self._named(interface)
        if name is not None:
            return self.all[name].joints
        return [joint.name for joint in self._runtime.twin.robot.arm_joints]

    def _named(self, interface: str) -> str | None:
        """Return the controller whose action or topic it is, if it is known."""
        parts = reversed(interface.split("/")[:-1])
        return next((part for part in parts if part in self.all), None)

    def refusal(self, interface: str) -> str:
        """Return why the controller of an action or topic takes nothing; empty where it does."""
        if words := self.without_program(self._joints(interface)):
            return words
        name = self._named(interface)
        if name is None or name in self.running:
            return ""
        made = self._bring_up
        if name in self._switched:
            why = "it was switched off"
        elif made is not None and name in made.inactive:
            why = f"the bring-up of {made.driver} loads it and does not start it"
        else:
            return ""
        state = "inactive" if self._runtime.distro.is_ros2 else "stopped"
        return (
            f"controller '{name}' is {state}: {why}; start it in place of "
            f"{self._of_same_joints(name)} with service switch_controller"
        )

    def _of_same_joints(self, name: str) -> str:
        others = sorted(self.conflicts(name, self.running))
        return " and ".join(f"'{other}'" for other in others) or "none"

    @cached_property
    def _bring_up(self) -> BringUp | None:
        """The bring-up of the driver, without what files of the workspace start."""
        runtime = self._runtime
        script = next(map(Path, runtime.argv), None)
        files = LaunchedControllers(runtime.packages.values(), script)
        made = bring_up_of(
            runtime.twin.robot, is_ros2=self._runtime.distro.is_ros2, is_named=files.name
        )
        if made is None:
            return None
        if files.has_own_bring_up:
            return None
        if any(files.starts(name) for name in made.inactive):
            return None
        arm = {joint.name for joint in runtime.twin.robot.arm_joints}
        has_own = any(
            declared.settings
            and name not in made.inactive
            and name not in made.active
            and arm.intersection(declared.joints)
            for name, declared in robot_controllers(runtime).items()
        )
        return None if has_own else self._with_the_one_named(made, files)

    def _with_the_one_named(self, made: BringUp, files: LaunchedControllers) -> BringUp:
        """Return a bring-up, with a controller that the program means in the place of the first.

        It is the plain one for trajectories, which simulators start instead of the driver's own,
        where nothing names that one or switches controllers: an assumption of the run.
        """
        first, held = next(iter(made.active)), made.held_for_trajectories
        if held is None or not files.command(held):
            return made
        if files.name(first) or files.name("SwitchController"):
            return made
        if self._runtime.recorder is not None:
            self._runtime.recorder.finding(
                "answer_assumed",
                f"controller '{held}' is assumed to run in place of '{first}', which {made.driver} "
                "starts by default: nothing in the workspace starts either",
                object_name=held,
            )
        return made.starting(held)
