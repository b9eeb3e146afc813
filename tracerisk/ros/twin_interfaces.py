"""All that the twin offers on the graph, found by the type of what a controller asks for.

Nothing here knows names of robots: whoever becomes a client of an action of a known type is
served under the name that they chose, unless the controller serves it itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from tracerisk.ros.gazebo.services import GazeboServices
from tracerisk.ros.graph.action_goal import ActionGoal
from tracerisk.ros.graph.actions import ActionChange, Actions
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.moveit.actions.execution_reports import ExecutionReports
from tracerisk.ros.moveit.actions.pick_place import PICKUP, PLACE, PickPlaceServer
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.moveit.services import EXECUTE_TRAJECTORY, MOVE_GROUP, MoveItInterfaces
from tracerisk.ros.moveit.servo import Servo
from tracerisk.ros.robot.action_topics import ActionTopics
from tracerisk.ros.robot.bring_up.display import Display
from tracerisk.ros.robot.bring_up.node_parameters import NodeParameters
from tracerisk.ros.robot.bring_up.system import SystemState
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.robot.controllers import ControllerManager
from tracerisk.ros.robot.grippers import GripperServer
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.streams.set_points import SetPoints
from tracerisk.ros.robot.trajectories.follow import TYPE as FOLLOW
from tracerisk.ros.robot.trajectories.follow import FollowServer
from tracerisk.ros.robot.wrench import WrenchTopics

_NODE = "/robot_driver"
Handler = Callable[[ActionGoal], None]


class TwinInterfaces:
    """Serves actions, command topics and services of the robot's driver to one run.

    `interfaces` makes the message classes of the ROS that the controller speaks. The drivers of
    makers, who stand above this room, share `messages`.
    """

    def __init__(self, runtime: Runtime, interfaces: Any) -> None:
        self._actions = runtime.client(Actions)
        self._system = runtime.client(SystemState)
        commands = self._commands = runtime.client(TwinCommands)
        messages = self.messages = TwinMessages(interfaces)
        follow = FollowServer(runtime, messages)
        self._types: dict[str, tuple[Handler, Handler]] = {
            FOLLOW: (follow.on_goal, follow.on_cancel)
        }
        if runtime.twin.robot.grippers:
            gripper = GripperServer(runtime, messages)
            for name, handler in gripper.handlers.items():
                self._types[name] = (handler, commands.cancel)
        if runtime.recorder is not None:
            moveit = MoveItInterfaces(runtime, messages)
            Servo(runtime, messages)
            self._types[MOVE_GROUP] = (moveit.on_goal, moveit.on_cancel)
            self._types[EXECUTE_TRAJECTORY] = (moveit.on_goal, moveit.on_cancel)
            if not messages.is_ros2:
                # MoveIt 2 has neither.
                ExecutionReports(runtime, messages, runtime.client(MoveGroupServer).execution)
                picking = PickPlaceServer(runtime, messages)
                self._types[PICKUP] = (picking.pickup, picking.on_cancel)
                self._types[PLACE] = (picking.place, picking.on_cancel)
            GazeboServices(runtime, messages)
        SetPoints(runtime, messages)
        self._served: set[tuple[str, str]] = set()
        self._actions.watch(self._on_action)
        if not hasattr(interfaces, "action"):
            ActionTopics(runtime, messages)
        ControllerManager(runtime, messages)
        NodeParameters(runtime, messages)
        Display(runtime, messages)
        WrenchTopics(runtime, messages)

    def take(self, types: Mapping[str, tuple[Handler, Handler]]) -> None:
        """Serve more types of actions: what takes a goal of each, and what cancels one."""
        self._types.update(types)

    def _on_action(self, change: ActionChange, name: str, type_name: str) -> None:
        if change != "client" or type_name not in self._types or (name, type_name) in self._served:
            return
        self._served.add((name, type_name))
        if words := self._system.words_of_slip(name, type_name):
            self._commands.report("name_assumed", f"action {words}", object_name=name)
        on_goal, on_cancel = self._types[type_name]
        self._actions.serve(
            name, type_name, node=_NODE, on_goal=on_goal, on_cancel=on_cancel, by_controller=False
        )
