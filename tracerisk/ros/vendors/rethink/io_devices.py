"""The devices of a Sawyer on the graph: its gripper, cuff, navigator and lights, as signals.

Each device has the topics `/io/NODE/DEVICE/config`, `state` and `command`; values are JSON.
Source: RethinkRobotics/intera_common (intera_core_msgs), and intera_sdk (io_interface.py,
gripper.py, gripper_factory.py, cuff.py, navigator.py, lights.py).
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.graph import Change
from tracerisk.ros.graph.topic_ends import Publication
from tracerisk.ros.messages.dialect import set_time
from tracerisk.ros.robot.grippers import measured_grip
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.streams.command_streams import CommandStreams
from tracerisk.ros.robot.twin_node import TwinNode
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.twin.physics.motion import PlanningError
from tracerisk.twin.robots.gripper_ends import gripper_ends

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

Value = bool | float

_CORE = "intera_core_msgs"
_PERIOD_NS = 50_000_000
_KEPT = 20  # commands that a state acknowledges
_TOPIC = re.compile(r"^/io/(\w+)(?:/(\w+))?/(config|state|command)$")
_OPEN_M = 0.041667  # MAX_POSITION of gripper.py
_STILL = 1e-3  # slower fingers stand still [m/s]
_BUTTONS = ("back", "circle", "ok", "show", "square", "triangle")
_COLOURS = ("blue", "green", "red")
_DEVICES: Mapping[tuple[str, str], Mapping[str, Value]] = {
    ("robot", "cuff"): dict.fromkeys(
        ("right_cuff", "right_button_upper", "right_button_lower"), False
    ),
    ("robot", "navigator"): {
        **{f"{side}_button_{name}": 0.0 for side in ("head", "right") for name in _BUTTONS},
        **{f"{side}_wheel": 0.0 for side in ("head", "right")},
    },
    ("robot", "robot"): {
        **{f"head_{name}_light": False for name in _COLOURS},
        **{f"right_hand_{name}_light": False for name in _COLOURS},
    },
}
"""The signals of each device as the run begins; buttons are not pressed."""
_GRIPPER = ("end_effector", "right_gripper")
_OF_GRIPPER: Mapping[str, Value] = {
    "calibrate": False, "reboot": False, "go": True, "has_error": False, "is_calibrated": True,
    "position_m": _OPEN_M, "speed_mps": 3.0, "dead_zone_m": 0.0, "right_gripper_tip_object_kg": 0.0,
}  # fmt: skip


class IoDevices(TwinNode):
    """Publishes the devices and takes what is set; only the gripper moves anything."""

    node = "/io_manager"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._streams = CommandStreams(self._commands)
        self._gripper = next(iter(self._twin.robot.grippers), None)
        self._values = {key: dict(signals) for key, signals in _DEVICES.items()}
        if self._gripper is not None:
            self._values[_GRIPPER] = dict(_OF_GRIPPER)
        self._taken: dict[tuple[str, str], list[Any]] = {key: [] for key in self._values}
        self._open: set[str] = set()
        self._graph.watch(self._on_change)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        matched = _TOPIC.match(name)
        if matched is None or not type_name.startswith(f"{_CORE}/IO") or name in self._open:
            return
        node, device, kind = matched.groups()
        key = (node, device or "")
        if key not in self._values and (device or node not in {value for value, _ in self._values}):
            return
        if change == "advertised" and kind == "command" and device:
            self._open.add(name)
            subscription = self._graph.subscribe(
                name,
                type_name,
                lambda message, sender: self._take(key, message, sender),
                node=self.node,
                by_controller=False,
            )
            subscription.hears_scenario = key != _GRIPPER
        elif change == "subscribed" and kind != "command":
            self._open.add(name)
            publication = self._graph.advertise(
                name, type_name, node=self.node, by_controller=False
            )
            self._go_on(publication, key, kind)

    def _go_on(self, publication: Publication, key: tuple[str, str], kind: str) -> None:
        publication.publish(self._message(key, kind))
        due_ns = (self._scheduler.now_ns // _PERIOD_NS + 1) * _PERIOD_NS
        self._scheduler.call_at(
            due_ns, lambda: self._go_on(publication, key, kind), background=True
        )

    # What is set

    def _take(self, key: tuple[str, str], message: Any, sender: Publication) -> None:
        """Set signals once, however often the command comes until it is acknowledged.

        A scenario presses buttons, and moves nothing itself.
        """
        taken, topic = self._taken[key], sender.topic
        if message.time in taken or (key == _GRIPPER and not sender.by_controller):
            return
        taken.append(message.time)
        del taken[:-_KEPT]
        try:
            signals = json.loads(message.args or "{}").get("signals", {})
            asked = {name: signal["data"][0] for name, signal in signals.items()}
        except (ValueError, TypeError, KeyError, IndexError, AttributeError):
            self._streams.refuse(topic, f"args '{message.args}' are no signals with data, as JSON")
            return
        for name, value in asked.items():
            if isinstance(value, bool | int | float):
                self._values[key][name] = value if isinstance(value, bool) else float(value)
        if key == _GRIPPER:
            self._move(topic, asked)

    def _move(self, topic: str, asked: Mapping[str, Any]) -> None:
        gripper = self._gripper
        if gripper is None:
            return
        if asked.get("go") is False:
            self._commands.rest(gripper.joints)
            return
        if "position_m" not in asked:
            return
        part = min(max(float(self._values[_GRIPPER]["position_m"]) / _OPEN_M, 0.0), 1.0)
        goal = gripper_ends(self._twin.robot, gripper).position(part)
        try:
            motion = self._twin.move_gripper(gripper.name, goal, max_effort=gripper.effort)
        except PlanningError as error:
            self._streams.refuse(topic, error.message)
            return
        self._commands.begin("gripper_command", motion, self._commands.stack())

    # What is reported

    def _message(self, key: tuple[str, str], kind: str) -> Any:
        node, device = key
        whose, what = ("Device" if device else "Node"), kind == "config"
        message = self._messages.new(f"{_CORE}/IO{whose}{'Configuration' if what else 'Status'}")
        set_time(message.time, EPOCH_NS + self._scheduler.now_ns)
        part = self._config if what else self._status
        if not device:
            message.node = part(node)
            message.devices = [part(name) for of, name in self._values if of == node]
            return message
        message.device = part(device)
        if what:
            message.signals = [self._config(name) for name in self._values[key]]
        else:
            message.signals = [self._signal(*signal) for signal in self._signals(key)]
            message.commands = list(self._taken[key])
        return message

    def _config(self, name: str) -> Any:
        message = self._messages.new(f"{_CORE}/IOComponentConfiguration")
        kind = "ElectricParallelGripper" if name == _GRIPPER[1] else name
        message.name, message.config = name, json.dumps({"props": {"type": kind}})
        return message

    def _status(self, name: str) -> Any:
        message = self._messages.new(f"{_CORE}/IOComponentStatus")
        message.name, message.status.tag = name, "ready"
        return message

    def _signal(self, name: str, value: Value) -> Any:
        message = self._messages.new(f"{_CORE}/IODataStatus")
        kind = "bool" if isinstance(value, bool) else "float"
        message.name, message.status.tag = name, "ready"
        message.format = json.dumps({"type": kind, "role": "output"})
        message.data = json.dumps([value])
        return message

    def _signals(self, key: tuple[str, str]) -> Iterator[tuple[str, Value]]:
        yield from self._values[key].items()
        gripper = self._gripper
        if key != _GRIPPER or gripper is None:
            return
        width, speed, effort = measured_grip(self._twin.joint_state(), gripper)
        is_moving = speed > _STILL
        part = gripper_ends(self._twin.robot, gripper).share(width)
        # Fingers that press and stand still between their ends hold something.
        holds = effort > 0.1 * gripper.effort and 0.02 < part < 0.98
        yield "is_moving", is_moving
        yield "is_gripping", holds and not is_moving
        yield "position_response_m", part * _OPEN_M
        yield "force_response_n", effort
