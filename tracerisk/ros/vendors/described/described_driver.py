"""A driver that is described, on the graph: its services, actions, topics and parameters."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from tracerisk.ros.controller.needs import Need, NeedKind
from tracerisk.ros.controller.thread import undisturbed
from tracerisk.ros.graph.action_goal import ActionGoal
from tracerisk.ros.graph.actions import ActionChange, Actions
from tracerisk.ros.graph.graph import Change
from tracerisk.ros.graph.graph_names import ANY_TYPE
from tracerisk.ros.graph.topic_ends import Publication
from tracerisk.ros.robot.bring_up.states import ControllerStates
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.state_topics import fill_joint_state
from tracerisk.ros.robot.streams.command_topics import JOINT_STATE_TYPE
from tracerisk.ros.robot.trajectories.robot_spaces import group_of_side
from tracerisk.ros.robot.twin_node import JOINTS, TwinNode
from tracerisk.ros.vendors.answers import Result
from tracerisk.ros.vendors.conventions import Conventions
from tracerisk.ros.vendors.described.described_parts import (
    DescribedArm,
    DescribedStreams,
    DriverState,
    case_of,
    is_named,
    short_name,
    take_rules,
)
from tracerisk.ros.vendors.described.motion_queue import Job
from tracerisk.ros.vendors.described.planned_motion import PlannedMotion
from tracerisk.ros.vendors.description import Case, Driver, Interface, InterfaceKind, Output
from tracerisk.ros.vendors.interface_checks import check_interface, types_in_use, unknown_package
from tracerisk.ros.vendors.message_paths import content_of
from tracerisk.ros.vendors.requests import Request
from tracerisk.twin.physics.motion import PlanningError

if TYPE_CHECKING:
    from tracerisk.instrument.tracer import Frame
    from tracerisk.ros.graph.runtime import Runtime


_STATE = re.compile(r"\$(\w+)")
_PLAYING = "PLAYING"  # of a driver whose state says whether its program runs
_NEEDED: Mapping[InterfaceKind, NeedKind] = {
    "services": "service",
    "actions": "action",
    "subscribed_topics": "command",
}


class DescribedDriver(TwinNode):
    """Serves what one description says, under its names in whatever namespace they are asked for.

    Raises:
        DriverError: the description does not fit the messages that it speaks of.
    """

    def __init__(
        self,
        driver: Driver,
        runtime: Runtime,
        messages: TwinMessages,
    ) -> None:
        take_rules(driver, runtime)
        super().__init__(runtime, messages)
        self._driver, self.node = driver, driver.node
        self._conventions = Conventions(driver.units, driver.rotation)
        self._state = DriverState(driver, runtime)
        self._queue, self._grips = self._state.queue, self._state.grips
        self._arms: dict[tuple[str | None, str | None], DescribedArm] = {}
        self._controllers = runtime.client(ControllerStates)
        self._streams = DescribedStreams(self._commands)
        self._planned = PlannedMotion()
        self._taken: set[tuple[str, str]] = set()
        known = [interface for interface in driver.interfaces if self._types(interface)]
        if driver.origin == "user" and driver.interfaces and not known:
            raise unknown_package(driver.interfaces[0])
        if driver.origin != "shipped":
            for interface in known:
                for type_name in self._types(interface):
                    check_interface(interface, type_name, messages, self._arm(interface).answers)
        self._interfaces = known
        for interface in (interface for interface in known if interface.kind == "services"):
            self._serve(interface)
        for name, output in driver.parameters.items():
            self._graph.parameters.offer(name, partial(self._parameter, output))
        self._graph.watch(self._on_change)
        runtime.client(Actions).watch(self._on_action)

    def _types(self, interface: Interface) -> tuple[str, ...]:
        return types_in_use(self._driver, interface, self._messages)

    def _arm(self, interface: Interface | None, name: str = "") -> DescribedArm:
        group, gripper = self._driver.group, self._driver.gripper
        if interface is not None:
            group, gripper = interface.group or group, interface.gripper or gripper
        group = group or group_of_side(self._twin.robot, name)
        if (group, gripper) not in self._arms:
            self._arms[group, gripper] = DescribedArm(
                self._driver, self._runtime, self._messages, self._state, group, gripper
            )
        return self._arms[group, gripper]

    def _parameter(self, output: Output) -> Any:
        if self._driver.packages and not any(map(self._messages.is_used, self._driver.packages)):
            return None
        return self._arm(None).answers.plain(output)

    def _request(self, interface: Interface, message: Any) -> Request:
        need = Need(_NEEDED[interface.kind], f"/{interface.name.strip('/')}", interface.types[0])
        on_large = partial(self._scheduler.needs.doubt, need)
        return Request(message, self._state, self._conventions, on_large)

    # Services

    def _serve(self, interface: Interface) -> None:
        for type_name in self._types(interface):
            answer = partial(self._answer, interface, type_name)
            if interface.name.startswith("/") and self._driver.origin != "shipped":
                self._graph.services.serve(
                    interface.name, type_name, answer, node=self.node, is_callback=False
                )
            else:
                name = interface.name.strip("/")
                base = "/".join(name.split("/")[-2:])
                self._graph.services.offer(base, type_name, answer, node=self.node)

    def _answer(self, interface: Interface, type_name: str, message: Any) -> Any:
        arm = self._arm(interface, interface.name)
        stack = self._commands.stack()
        self._scheduler.touch()
        case: Case | None = None
        jobs: list[Job] = []
        result = Result()
        request = self._request(interface, message)
        try:
            case = case_of(interface, request)
            self._set(interface, case, request)
            result, jobs = self._do(interface, case, request, stack, name=interface.name)
            if request.flag(case.wait, default=bool(jobs) or case.wait is not None):
                timeout_s = request.seconds(case.timeout)
                result = self._wait(jobs, timeout_s)
            elif jobs and jobs[0].outcome:
                result = Result(jobs[0].outcome, jobs[0].message)
        except PlanningError as error:
            result = self._refused(interface, error, stack)
        outputs = interface.response if case is None or case.response is None else case.response
        arm.answers.note_reading(outputs, result)
        return arm.answers.fill(self._messages.response(type_name), outputs, result, message)

    def _wait(self, jobs: list[Job], timeout_s: float | None) -> Result:
        """Wait for motions, or without any for all that go on."""

        def is_over() -> bool:
            if jobs:
                return all(job.outcome for job in jobs)
            return not (self._queue.is_busy or self._grips.is_busy)

        self._scheduler.wait_until(
            is_over,
            timeout_ns=None if timeout_s is None else round(timeout_s * 1e9),
            reason="the arm to finish",
        )
        if not is_over():
            return Result("timeout", f"the motion takes longer than {timeout_s:g} s")
        return Result(jobs[0].outcome, jobs[0].message) if jobs else Result()

    def _refused(
        self, interface: Interface, error: PlanningError, stack: tuple[Frame, ...]
    ) -> Result:
        self._commands.report(
            "command_ignored", f"{short_name(interface)} moved nothing: {error.message}", stack
        )
        return Result(error.failure, error.message)

    # What is done

    def _set(self, interface: Interface, case: Case, request: Request) -> None:
        for name, value in case.set.items():
            if name == "enabled":
                enabled = request.flag(value, default=True)
                self._queue.is_enabled = enabled
                if not enabled:
                    self._queue.stop()
            elif value.unit or name.endswith("_scaling"):
                self._state[name] = request.number(value, "plain", value.unit or "fraction")
            else:
                # A mode is a number in ROS 2 and a message of one in ROS 1.
                content = content_of(request.raw(value))
                self._state[name] = content.decode() if isinstance(content, bytes) else content
                if name == "program" and content == _PLAYING:
                    self._controllers.program_started()
                elif name == "program":
                    self._controllers.program_stopped(interface.name)
                self._hold_trajectories(name)

    def _hold_trajectories(self, name: str) -> None:
        """Hold the controllers where the state is not as trajectories need it."""
        needed = self._driver.trajectories_need.get(name, ())
        if needed:
            is_so = str(self._state[name]) in map(str, needed)
            words = (
                f"the arm was put into {name} {self._state[name]}, in which its driver carries out "
                f"no trajectories; allowed: {', '.join(map(str, needed))}"
            )
            self._controllers.hold("" if is_so else words)

    def _do(
        self,
        interface: Interface,
        case: Case,
        request: Request,
        stack: tuple[Frame, ...],
        on_end: Callable[[Job], None] = lambda job: None,  # noqa: ARG005
        *,
        name: str,
        is_goal: bool = False,
    ) -> tuple[Result, list[Job]]:
        """Do what a case says; a motion is returned as a job, over or not.

        `name` is the one under which it was asked for, which may say which arm is meant.
        """
        result = self._do_at_rest(interface, case, stack, name)
        if result is not None:
            return result, []
        kind = short_name(interface)
        arm = self._arm(interface, name)
        if case.execute:
            planned = self._planned.begun_at(arm.motion.joints, arm.motion.positions())
            follow = partial(self._commands.twin.follow, planned)
            job = Job(kind, stack, follow, on_end, is_goal)
            self._queue.ask(job, "replace")
            return Result(), [job]
        if case.effect == "solve":
            with undisturbed(self._scheduler.current):
                return arm.motions.solve(case, request), []
        if case.effect == "set_tool":
            arm.motion.offset = arm.motions.tool(case, request)
            return Result(), []
        if case.stream and (refused := self._queue.refused()):
            words = self._queue.why(refused)
            self._commands.report("command_ignored", f"{kind} moved nothing: {words}", stack)
            return Result(refused, words), []
        if case.stream:
            with undisturbed(self._scheduler.current):
                self._streams.take(arm, interface, case, interface.name, request)
            return Result(), []
        if case.effect == "grip":
            job = Job(kind, stack, arm.motions.grip(case, request), on_end, is_goal)
            self._grips.ask(job, "replace")
            return Result(), [job]
        rule = case.while_moving or interface.while_moving or self._driver.while_moving
        make = arm.motions.move if case.effect == "move" else arm.motions.velocity
        made = make(case, request)
        if case.plan:
            with undisturbed(self._scheduler.current):
                self._planned.keep(made(), arm.motion.positions())
            return Result(), []
        if rule == "wait" and interface.kind == "services":
            self._wait([], None)
            rule = "replace"
        if case.effect == "velocity":
            rule = "replace"

        def start() -> Any:
            trajectory = made()
            if trajectory is None:
                self._commands.twin.stop(arm.motion.joints)
                return None
            return self._commands.twin.follow(trajectory)

        job = Job(kind, stack, start, on_end, is_goal)
        self._queue.ask(job, "queue" if rule == "wait" else rule)
        return Result(), [job]

    def _do_at_rest(
        self, interface: Interface, case: Case, stack: tuple[Frame, ...], name: str
    ) -> Result | None:
        """Report and stop what a case says; return the result where nothing is to move then."""
        kind = short_name(interface)
        for words, what in (
            (case.note, "not_simulated"),
            (case.refuse, "not_simulated"),
            (case.need, "unprovided"),
        ):
            if words:
                self._commands.report(what, f"{kind}: {words}", stack, object_name=kind)
        if case.refuse:
            return Result("not_simulated", case.refuse)
        if case.ignore:
            return self._ignored(interface, case, stack)
        if case.clear:
            self._queue.clear()
        if case.stop and not case.set:
            self._commands.stop_came(kind)
        if case.stop:
            self._queue.stop()
            self._grips.stop()
            self._commands.rest(self._arm(interface, name).motion.joints)
        return None if case.effect or case.execute else Result()

    def _ignored(self, interface: Interface, case: Case, stack: tuple[Frame, ...]) -> Result:
        """Report what the driver answers as if it did it; `$name` is a value of its state."""
        words = _STATE.sub(lambda name: str(self._state[name[1]]), case.ignore)
        name = short_name(interface)
        self._commands.report(
            "command_ignored",
            f"{name} moved nothing: {words}",
            stack,
            object_name=name,
            may_stream=True,
        )
        return Result()

    # Actions

    def _on_action(self, change: ActionChange, name: str, type_name: str) -> None:
        if change != "client" or (name, type_name) in self._taken:
            return
        for interface in self._interfaces:
            if (
                interface.kind == "actions"
                and type_name in interface.types
                and is_named(interface.name, name)
            ):
                self._taken.add((name, type_name))
                self._runtime.client(Actions).serve(
                    name,
                    type_name,
                    node=self.node,
                    on_goal=partial(self._on_goal, interface),
                    on_cancel=self._on_cancel,
                    by_controller=False,
                )
                return

    def _on_goal(self, interface: Interface, goal: ActionGoal) -> None:
        goal.accept()
        request = self._request(interface, goal.message)
        try:
            case = case_of(interface, request)
            self._set(interface, case, request)
            ended = partial(self._end_goal, interface, case, goal)
            goal.data = []
            result, jobs = self._do(
                interface,
                case,
                request,
                goal.stack,
                lambda job: ended(Result(job.outcome, job.message)),
                is_goal=True,
                name=goal.client.name,
            )
            goal.data = jobs
            if not jobs or not request.flag(case.wait, default=True):
                ended(result)
            elif interface.feedback and not goal.state.is_terminal:
                self._feed_back(interface, goal)
        except PlanningError as error:
            result = self._refused(interface, error, goal.stack)
            self._end_goal(interface, None, goal, result)

    def _end_goal(
        self, interface: Interface, case: Case | None, goal: ActionGoal, result: Result
    ) -> None:
        if goal.state.is_terminal:
            return
        outputs = interface.response if case is None or case.response is None else case.response
        made = self._messages.part(goal.client.type_name, "Result")
        answers = self._arm(interface, goal.client.name).answers
        filled = answers.fill(made, outputs, result, goal.message)
        goal.end(result.outcome, filled, result.message)

    def _on_cancel(self, goal: ActionGoal) -> None:
        goal.accept_cancel()
        for job in goal.data or ():
            queue = self._grips if job in self._grips else self._queue
            queue.drop(job)

    def _feed_back(self, interface: Interface, goal: ActionGoal) -> None:
        period_ns = round(1e9 / interface.rate)

        def notify() -> None:
            if goal.state.is_terminal:
                return
            made = self._messages.part(goal.client.type_name, "Feedback")
            answers = self._arm(interface, goal.client.name).answers
            goal.publish_feedback(answers.fill(made, interface.feedback, Result(), goal.message))
            self._scheduler.call_at(self._scheduler.now_ns + period_ns, notify, background=True)

        self._scheduler.call_at(self._scheduler.now_ns + period_ns, notify, background=True)

    # Topics

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        kind = {"advertised": "subscribed_topics", "subscribed": "published_topics"}.get(change)
        for interface in self._interfaces:
            if (
                interface.kind == kind
                and type_name in interface.types
                and is_named(interface.name, name)
            ):
                if kind == "subscribed_topics":
                    self._listen(interface, name, type_name)
                else:
                    self._publish(interface, name, type_name)
                return
        if kind == "subscribed_topics" and any(map(self._messages.is_used, self._driver.packages)):
            self._note_other_type(name, type_name)

    def _note_other_type(self, topic: str, type_name: str) -> None:
        """Report that a topic of the driver is published with another type: nothing arrives."""
        for interface in self._interfaces:
            # A name of one word may be another node's.
            if interface.kind != "subscribed_topics" or "/" not in interface.name.strip("/"):
                continue
            is_heard = any(one.type_name == type_name for one in self._graph.subscriptions(topic))
            if is_named(interface.name, topic) and type_name != ANY_TYPE and not is_heard:
                takes = " or ".join(interface.types)
                self._streams.refuse(
                    topic,
                    f"it is published as {type_name}, and {self._driver.name} takes {takes}: no "
                    "message arrives",
                )
                return

    def _listen(self, interface: Interface, name: str, type_name: str) -> None:
        def deliver(message: Any, publication: Publication) -> None:
            if not publication.by_controller:
                return
            request = self._request(interface, message)
            try:
                with undisturbed(self._scheduler.current):
                    self._take(interface, name, request)
            except PlanningError as error:
                self._streams.refuse(name, error.message)

        self._hear(name, type_name, deliver)

    def _key(self, name: str, type_name: str) -> str:
        return f"{name} {type_name}"

    def _take(self, interface: Interface, topic: str, request: Request) -> None:
        case, stack = case_of(interface, request), self._commands.stack()
        self._set(interface, case, request)
        is_motion = case.effect in ("move", "velocity")
        queued = (interface.while_moving or self._driver.while_moving) == "queue"
        waits = queued and case.effect == "move" and not case.stream
        if waits or not is_motion or case.ignore:
            self._do(interface, case, request, stack, name=topic)
        elif refused := self._queue.refused():
            self._streams.refuse(topic, self._queue.why(refused))
        else:
            self._streams.take(self._arm(interface, topic), interface, case, topic, request)

    def _publish(self, interface: Interface, name: str, type_name: str) -> None:
        answers = self._arm(interface, name).answers
        is_of_joints = interface.response is None and type_name == JOINT_STATE_TYPE

        def make(message: Any, topic: str) -> Any:
            del topic
            if is_of_joints:
                fill_joint_state(message, self._runtime)
            return answers.fill(message, interface.response or {}, Result())

        sensors = JOINTS if is_of_joints or answers.asks_sensors(interface.response) else ()
        self._report_on(name, type_name, interface.rate, make, sensors, latch=interface.latch)
