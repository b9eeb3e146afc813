"""What the controller of a Doosan arm reports and keeps: states, frames, tools, pins."""

# ruff: noqa: ARG001, ARG002, ARG005 - every handler takes a request and an answer
from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from tracerisk.ros.robot.arm_motion import ArmMotion
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import TwinNode
from tracerisk.ros.transforms.poses import ORIGIN, compose
from tracerisk.ros.vendors.doosan.motion import DoosanMotion, pose_of, rows_of, values_of
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.physics.motion import PlanningError, Pose

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_STANDBY, _MOVING = 1, 2
_IDLE, _BUSY = 0, 2
_POLLED = 10  # times that a program asks for an input which it waits for
_POLLED_NS = 2_000_000_000  # and for how long, while the arm rests

Handler = Callable[[Any, Any], bool | None]


class DoosanReports(TwinNode):
    """Answers what moves nothing."""

    node = "/dsr_controller2"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._arm = ArmMotion(self._commands)
        self._motion = DoosanMotion(self._arm)
        self._live: Motion | None = None
        self._tcps: dict[str, Pose] = {"": ORIGIN}
        self._tools: set[str] = {""}
        self._current = {"tcp": "", "tool": ""}
        self._pins: dict[tuple[str, int], float] = {}
        self._polls: dict[tuple[str, int], tuple[object, int, int]] = {}

    def _services(self) -> Mapping[str, Mapping[str, Handler]]:
        """Return the handlers by folder and name."""
        return {
            "system": {
                "get_robot_state": self._state,
                "get_current_pose": self._pose,
            },
            "motion": {
                "check_motion": self._check,
                "change_operation_speed": self._share,
                "fkin": self._forward,
                "ikin": self._inverse,
                "trans": self._trans,
            },
            "aux_control": {
                "get_current_posx": self._posx,
                "get_desired_posx": lambda asked, answer: _filled(
                    answer, pos=values_of(self._motion.here())
                ),
                "get_current_rotm": self._rotation,
                "get_current_solution_space": lambda asked, answer: _filled(
                    answer, sol_space=self._motion.solution_space()
                ),
            },
            "tcp": {
                "config_create_tcp": self._create_tcp,
                "config_delete_tcp": self._delete_tcp,
                "set_current_tcp": self._set_tcp,
                "get_current_tcp": lambda asked, answer: _filled(answer, info=self._current["tcp"]),
            },
            "tool": {
                "config_create_tool": self._create_tool,
                "config_delete_tool": self._delete_tool,
                "set_current_tool": self._set_tool,
                "get_current_tool": lambda asked, answer: _filled(
                    answer, info=self._current["tool"]
                ),
            },
            "io": {
                f"{verb}_{place}": handler(place)
                for verb, handler, places in (
                    ("set", self._set_pin, ("ctrl_box_digital_output", "tool_digital_output")),
                    ("set", self._set_pin, ("ctrl_box_analog_output",)),
                    ("get", self._get_pin, ("ctrl_box_digital_output", "tool_digital_output")),
                    ("get", self._get_input, ("ctrl_box_digital_input", "tool_digital_input")),
                    ("get", self._get_pin, ("ctrl_box_analog_input",)),
                )
                for place in places
            },
        }

    def _conclude(self, answer: Any, result: Any) -> None:
        answer.success = result is None or result

    # Modes and states

    @property
    def _is_busy(self) -> bool:
        return self._live is not None and self._live.outcome == "active"

    def _state(self, request: Any, answer: Any) -> bool:
        self._scheduler.touch()
        return _filled(answer, robot_state=_MOVING if self._is_busy else _STANDBY)

    def _check(self, request: Any, answer: Any) -> bool:
        self._scheduler.touch()
        return _filled(answer, status=_BUSY if self._is_busy else _IDLE)

    def _share(self, request: Any, answer: Any) -> bool:
        if not 1 <= request.speed <= 100:
            return False
        self._motion.share = request.speed / 100.0
        return True

    # Where it is

    def _pose(self, request: Any, answer: Any) -> bool:
        self._scheduler.touch()
        self._reading.asked("encoder")
        is_joint = request.space_type == 0
        positions = self._motion.positions() if is_joint else values_of(self._motion.here())
        return _filled(answer, pos=positions)

    def _posx(self, request: Any, answer: Any) -> bool:
        self._scheduler.touch()
        self._reading.asked("encoder")
        row = self._messages.new("std_msgs/Float64MultiArray")
        row.data = [*values_of(self._motion.here()), float(self._motion.solution_space())]
        return _filled(answer, task_pos_info=[row])

    def _rotation(self, request: Any, answer: Any) -> bool:
        self._reading.asked("encoder")
        rows = []
        for values in rows_of(self._motion.here()):
            row = self._messages.new("std_msgs/Float64MultiArray")
            row.data = list(values)
            rows.append(row)
        return _filled(answer, rot_matrix=rows)

    def _forward(self, request: Any, answer: Any) -> bool:
        return _filled(answer, conv_posx=values_of(self._motion.of_joints(list(request.pos))))

    def _inverse(self, request: Any, answer: Any) -> bool:
        try:
            return _filled(answer, conv_posj=self._motion.to_joints_of(pose_of(request.pos)))
        except PlanningError:
            return False

    def _trans(self, request: Any, answer: Any) -> bool:
        try:
            moved = self._motion.pose(request.delta, request.ref, 1, pose_of(request.pos))
        except PlanningError:
            return False
        return _filled(answer, trans_pos=values_of(moved))

    # Tools and pins

    def _create_tcp(self, request: Any, answer: Any) -> None:
        self._tcps[request.name] = pose_of(request.pos)

    def _delete_tcp(self, request: Any, answer: Any) -> bool:
        return bool(request.name) and self._tcps.pop(request.name, None) is not None

    def _set_tcp(self, request: Any, answer: Any) -> None:
        if request.name not in self._tcps:
            self._assume("tool centre point", request.name, "no offset from the flange")
            self._tcps[request.name] = ORIGIN
        self._current["tcp"] = request.name
        self._motion.tcp = compose(ORIGIN, self._tcps[request.name])

    def _create_tool(self, request: Any, answer: Any) -> None:
        self._tools.add(request.name)

    def _delete_tool(self, request: Any, answer: Any) -> bool:
        is_known = bool(request.name) and request.name in self._tools
        self._tools.discard(request.name or "-")
        return is_known

    def _set_tool(self, request: Any, answer: Any) -> None:
        if request.name not in self._tools:
            self._assume("tool", request.name, "no mass")
            self._tools.add(request.name)
        self._current["tool"] = request.name

    def _assume(self, kind: str, name: str, taken: str) -> None:
        """Report what is taken for a part that only the robot's own box knows."""
        create = "config_create_tcp" if kind != "tool" else "config_create_tool"
        self._commands.report(
            "assumed_setting",
            f"{kind} '{name}' is not created by the controller, so it is registered in the "
            f"controller box: it is taken with {taken}; call {create} for what it is",
            object_name=name,
        )

    def _set_pin(self, place: str) -> Handler:
        def take(request: Any, answer: Any) -> None:
            number = request.index if hasattr(request, "index") else request.channel
            self._pins[place, number] = float(request.value)
            self._commands.report("not_simulated", f"{place} {number} was set: nothing hangs on it")

        return take

    def _get_pin(self, place: str) -> Handler:
        def fill(request: Any, answer: Any) -> bool:
            number = request.index if hasattr(request, "index") else request.channel
            return _filled(answer, value=type(answer.value)(self._pins.get((place, number), 0.0)))

        return fill

    def _get_input(self, place: str) -> Handler:
        """Return what answers for an input; one that is waited for is assumed to change."""
        get = self._get_pin(place)

        def fill(request: Any, answer: Any) -> bool | None:
            pin, now_ns = (place, request.index), self._scheduler.now_ns
            outputs = sorted(item for item in self._pins.items() if "output" in item[0][0])
            rest = ([round(value, 1) for value in self._motion.positions()], outputs)
            before, since_ns, count = self._polls.get(pin, (None, now_ns, 0))
            if before != rest:
                since_ns, count = now_ns, 0
            self._polls[pin] = rest, since_ns, count + 1
            if count >= _POLLED and now_ns - since_ns >= _POLLED_NS:
                self._pins[pin] = 1.0 - self._pins.get(pin, 0.0)
                self._polls[pin] = rest, now_ns, 0
                self._commands.report(
                    "answer_assumed",
                    f"{place} {request.index} is asked for again and again while nothing moves: "
                    f"it is assumed to become {self._pins[pin]:.0f}",
                    object_name=f"{place} {request.index}",
                )
            return get(request, answer)

        return fill


def _filled(answer: Any, **values: Any) -> bool:
    for name, value in values.items():
        setattr(answer, name, value)
    return True
