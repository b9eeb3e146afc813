"""What the twin publishes as a real robot's drivers do: states of joints and controllers, time.

A driver that runs in a namespace publishes its joint states there: so does the twin, in those in
which the controller uses an interface of the robot.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from tracerisk.ros.graph.actions import ActionChange, Actions
from tracerisk.ros.graph.graph import Change
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.graph.sensor_reading import JOINT_STATES_HZ
from tracerisk.ros.messages.dialect import set_time
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.robot.bring_up.states import robot_controllers
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.state_order import StateOrder
from tracerisk.ros.robot.streams.command_topics import JOINT_STATE_TYPE, is_command_topic
from tracerisk.ros.robot.trajectories.joint_names import JointNames
from tracerisk.ros.robot.twin_node import JOINTS, TopicStream, TwinNode
from tracerisk.ros.time.clock import EPOCH_NS

JOINT_STATES = "/joint_states"

CLOCK = "/clock"
CLOCK_TYPE = "rosgraph_msgs/Clock"
CLOCK_HZ = 100.0
"""How often the simulated time is published while somebody listens."""

CONTROLLER_STATE_TYPE = "control_msgs/JointTrajectoryControllerState"
_CONTROLLER_STATE = re.compile(r"(?:^|/)([^/]+)/(?:state|controller_state)$")
"""The topic of a trajectory controller's state, below its name: of ROS 1 and of ROS 2."""

_CLOCK_PUBLISHER = "/clock_publisher"
# Controllers of ros_control that publish joint states, in a namespace of their own where it is set
# (`use_local_topics` of the joint state broadcaster).
_STATE_CONTROLLER = re.compile(r"_state_(controller|broadcaster)$")
_DRIVERS = ("control_msgs/", "moveit_msgs/")
"""The packages of actions that a robot's driver or its move_group serves."""


class TwinTopics(TwinNode):
    """Publishes states of joints and of trajectory controllers, and the clock, to who subscribes.

    `interfaces` makes the classes that the controller receives. What is published keeps no run
    going: a controller that only listens still comes to its end.
    """

    node = "/joint_state_publisher"

    def __init__(self, runtime: Runtime, interfaces: Interfaces | Interfaces2) -> None:
        super().__init__(runtime, TwinMessages(interfaces))
        self._sequence = 0
        self._asked: set[str] = set()
        self._used: set[str] = set()
        self._publish_states(JOINT_STATES)
        clock = self._graph.advertise(CLOCK, CLOCK_TYPE, node=_CLOCK_PUBLISHER, by_controller=False)
        TopicStream(runtime, clock, CLOCK_HZ, self._clock)
        self._graph.watch(self._on_change)
        runtime.client(Actions).watch(self._on_action)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change == "subscribed" and type_name == JOINT_STATE_TYPE:
            if name.endswith(JOINT_STATES):
                self._asked.add(name)
        elif change == "subscribed" and type_name == CONTROLLER_STATE_TYPE:
            controller = _CONTROLLER_STATE.search(name)
            if controller is not None and name not in self._reported:
                self._publish_controller(name, controller[1])
            return
        elif change == "advertised" and is_command_topic(name, type_name):
            self._used.add(name)
        elif change == "served":
            servers = self._graph.services.served()
            if not any(server.name == name and server.is_callback for server in servers):
                self._used.add(name)
        else:
            return
        self._publish_asked()

    def _on_action(self, change: ActionChange, name: str, type_name: str) -> None:
        if change == "client" and type_name.startswith(_DRIVERS):
            self._used.add(name)
            self._publish_asked()

    def _publish_asked(self) -> None:
        """Publish on the topics that somebody subscribes to and a driver would publish on."""
        for topic in sorted(self._asked - self._reported):
            space = topic.removesuffix(JOINT_STATES)
            is_used = any(name.startswith(f"{space}/") for name in self._used)
            if is_used or _STATE_CONTROLLER.search(space):
                self._publish_states(topic)

    def _publish_states(self, topic: str) -> None:
        self._publish(topic, JOINT_STATE_TYPE, self._joint_state, yields=topic != JOINT_STATES)

    def _publish_controller(self, topic: str, controller: str) -> None:
        """Publish the state of a trajectory controller, unless somebody else does."""
        joints = self._joints_of(controller)
        make = partial(self._controller_state, joints)
        self._publish(topic, CONTROLLER_STATE_TYPE, make, yields=True)

    def _publish(
        self, topic: str, type_name: str, make: Callable[[], Any], *, yields: bool
    ) -> None:
        self._reported.add(topic)
        sensors = self._reading.named(*JOINTS)
        self._stream(topic, type_name, JOINT_STATES_HZ, make, sensors, yields=yields)

    def _joints_of(self, controller: str) -> tuple[str, ...]:
        """Return the joints of a controller; all of the arm for one that nobody describes."""
        known = robot_controllers(self._runtime).get(controller)
        if known is not None and known.joints:
            return known.joints
        return tuple(joint.name for joint in self._twin.robot.arm_joints)

    def _controller_state(self, joints: Sequence[str]) -> Any:
        """Return the state of a controller of joints, whose set points are where they are.

        A real one follows its set points closely too, from the start of a motion to its end.
        """
        state = self._twin.joint_state()
        message = self._messages.new(CONTROLLER_STATE_TYPE)
        self._now(message.header)
        places = [state.names.index(joint) for joint in joints if joint not in state.absent]
        message.joint_names = [state.names[i] for i in places]
        # ROS 2 has renamed them, and Humble fills the older ones too.
        for name in ("desired", "actual", "reference", "feedback"):
            if hasattr(message, name):
                getattr(message, name).positions = [state.position[i] for i in places]
                getattr(message, name).velocities = [state.velocity[i] for i in places]
        message.error.positions = [0.0] * len(places)
        message.error.velocities = [0.0] * len(places)
        return message

    def _joint_state(self) -> Any:
        message = self._messages.new(JOINT_STATE_TYPE)
        self._sequence += 1
        if not self._messages.is_ros2:
            message.header.seq = self._sequence
        self._now(message.header)
        order = self._runtime.client(StateOrder).places(self._twin.joint_state().names)
        fill_joint_state(message, self._runtime, order)
        return message

    def _clock(self) -> Any:
        message = self._messages.new(CLOCK_TYPE)
        set_time(message.clock, EPOCH_NS + self._scheduler.now_ns)
        return message


def fill_joint_state(message: Any, runtime: Runtime, order: Sequence[int] | None = None) -> None:
    """Fill a sensor_msgs/JointState with all joints of the twin, by default in its own order.

    `order` are their places in the order of another driver. After them come the names that a
    driver has for several of them; a world may order all anew.
    """
    state = runtime.twin.joint_state()
    names = runtime.client(JointNames)
    places = [i for i in order or range(len(state.names)) if state.names[i] not in state.absent]
    present = [state.names[i] for i in places]
    more = [name for name in names.of_joints if {*names.joints_of(name)} <= {*present}]
    joints = [*present, *more]
    message.name = runtime.graph.carrier.world.ordered(joints)
    listed = [joints.index(name) for name in message.name]
    for key, values, combine in (
        ("position", state.position, names.value),
        ("velocity", state.velocity, names.value),
        ("effort", state.effort, names.effort),
    ):
        numbers = [values[i] for i in places]
        of_joints = dict(zip(present, numbers, strict=True)) if more else {}
        numbers += [combine(name, of_joints) for name in more]
        setattr(message, key, [numbers[i] for i in listed])
