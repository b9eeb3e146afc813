"""Nodes."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor, ParameterEvent

from tracerisk.ros.controller.frames import controller_frame
from tracerisk.ros.controller.thread import Meaning
from tracerisk.ros.graph.parameter_files import overrides_of

from ._arguments import FLAG, Arguments, parse_arguments
from ._handle import Handle
from ._logger import RcutilsLogger
from ._node_entities import KEPT, NodeEntities
from ._node_graph import NodeGraph
from ._node_parameters import NodeParameters
from ._rclpy_pybind11 import NodeNameNonExistentError
from ._run import run
from .callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from .clock import Clock, ROSClock
from .context import Context
from .exceptions import NotInitializedException

# As in the real library: who imports nodes has `rclpy.executors` too.
from .executors import Executor as _Executor  # noqa: F401
from .logging_service import LoggingService
from .parameter import Parameter
from .parameter_service import ParameterService
from .qos import qos_profile_parameter_events
from .type_description_service import START_TYPE_DESCRIPTION_SERVICE_PARAM, TypeDescriptionService

__all__ = ["Node", "NodeNameNonExistentError"]


class Node(NodeEntities, NodeGraph, NodeParameters):
    """A node: publishers, subscriptions, services, timers, parameters, under one name.

    Raises:
        NotInitializedException: `rclpy.init()` has not been called.
        InvalidNodeNameException: the name is not one that ROS takes.
        InvalidNamespaceException: the namespace is not.
    """

    def __init__(
        self,
        node_name: str,
        *,
        context: Context | None = None,
        cli_args: Sequence[str] | None = None,
        namespace: str | None = None,
        use_global_arguments: bool = True,
        enable_rosout: bool = True,
        rosout_qos_profile: Any = None,
        start_parameter_services: bool = True,
        parameter_overrides: Sequence[Parameter] | None = None,
        allow_undeclared_parameters: bool = False,
        automatically_declare_parameters_from_overrides: bool = False,
        enable_logger_service: bool = False,
    ) -> None:
        state = run()
        self._context = state.default_context if context is None else context
        if not self._context.is_valid:
            raise NotInitializedException("cannot create node")
        self._context._join()
        own = parse_arguments([FLAG, *cli_args]) if cli_args else Arguments()
        everyones = self._context.arguments if use_global_arguments else Arguments()
        given = Arguments(parameters=list(overrides_of(state.runtime.parameters)))
        self._handle = Handle()
        self._sources = (own, everyones, given)
        self._take_names(node_name, namespace)
        self._parameters = {}
        self._descriptors = {}
        self._pre_set_parameters_callbacks = []
        self._on_set_parameters_callbacks = []
        self._post_set_parameters_callbacks = []
        self._allow_undeclared_parameters = allow_undeclared_parameters
        self._parameter_overrides = self._overrides(parameter_overrides or ())
        for name in KEPT:
            setattr(self, name, [])
        self._executor: Any = None
        self._taken = ""
        self._default_callback_group = MutuallyExclusiveCallbackGroup()
        self._rate_group = ReentrantCallbackGroup()
        self._clock = ROSClock()
        self._logger = RcutilsLogger(self.get_fully_qualified_name().strip("/").replace("/", "."))
        self._rosout: Any = None
        if enable_rosout and self._context.arguments.has_rosout:
            state.unheard_loggers.discard(self._logger.name)
            self._rosout = state.graph.advertise(
                "/rosout",
                "rcl_interfaces/Log",
                node=self.get_fully_qualified_name(),
                copy=lambda message: message,
            )
            state.rosouts[self._logger.name] = self._rosout
        else:
            state.unheard_loggers.add(self._logger.name)
        self._event_publisher = self.create_publisher(
            ParameterEvent, "/parameter_events", qos_profile_parameter_events
        )
        state.nodes.append(self)
        if not self._parameter_overrides.get("use_sim_time"):
            self.declare_parameter("use_sim_time", False)
        else:
            self.declare_parameter("use_sim_time", Parameter.Type.BOOL)
        if START_TYPE_DESCRIPTION_SERVICE_PARAM not in self._parameters:
            self.declare_parameter(
                START_TYPE_DESCRIPTION_SERVICE_PARAM, True, ParameterDescriptor(read_only=True)
            )
        if automatically_declare_parameters_from_overrides:
            rest = [name for name in self._parameter_overrides if name not in self._parameters]
            self.declare_parameters(
                "", [(name, self._parameter_overrides[name].value) for name in rest]
            )
        if start_parameter_services:
            self._parameter_service = ParameterService(self)
        if enable_logger_service:
            self._logger_service = LoggingService(self)
        # Humble has no such service.
        if run().runtime.distro.name == "jazzy":
            self._type_description_service = TypeDescriptionService(self)

    def _overrides(self, given: Sequence[Parameter]) -> dict[str, Parameter]:
        full_name = self.get_fully_qualified_name()
        parameters: dict[str, Parameter] = {}
        for source in reversed(self._sources):
            values = source.overrides(full_name)
            parameters |= {name: Parameter(name, value=_plain(v)) for name, v in values.items()}
        return parameters | {parameter.name: parameter for parameter in given}

    @property
    def handle(self) -> Handle:
        """What stands for the node in the middleware: good until the node is destroyed."""
        return self._handle

    @handle.setter
    def handle(self, value: Any) -> None:
        raise AttributeError("handle cannot be modified after node creation")

    @property
    def executor(self) -> Any:
        """The executor that runs the callbacks, if any."""
        return self._executor

    @executor.setter
    def executor(self, new_executor: Any) -> None:
        current = self._executor
        if current is new_executor:
            return
        if current is not None:
            self._taken = _taken_from(current) if getattr(current, "_spinners", ()) else ""
            current.remove_node(self)
        self._executor = new_executor
        if new_executor is not None:
            new_executor.add_node(self)

    def _meaning_of_wait(self) -> Meaning:
        """Return what it means that a thread waits for a callback of the node.

        An executor that waits for work runs it in time; else nothing does.
        """
        executor, name = self._executor, self.get_fully_qualified_name()
        is_held = executor is not None and self in executor._nodes
        if is_held and executor._takes_work:
            return Meaning("blocked")
        if is_held and executor._spinners:
            kind = type(executor).__name__
            return Meaning("unmet", f"no thread of the {kind} that spins node {name} is free")
        taken = f" since {self._taken}" if self._taken else ""
        return Meaning("unmet", f"nothing spins node {name}{taken}")

    context = property(attrgetter("_context"), doc="The context that the node lives in.")

    @property
    def default_callback_group(self) -> CallbackGroup:
        """The group of what is given none: one callback at a time."""
        return self._default_callback_group

    def get_clock(self) -> Clock:
        """Return the clock."""
        return self._clock

    def get_logger(self) -> RcutilsLogger:
        """Return the logger."""
        return self._logger

    def add_waitable(self, waitable: Any) -> None:
        """Ask `waitable` for work too."""
        self._waitables.append(waitable)
        if waitable._node is None:
            waitable._node = self

    def remove_waitable(self, waitable: Any) -> None:
        """Ask `waitable` for work no longer."""
        if waitable in self._waitables:
            self._waitables.remove(waitable)

    def destroy_node(self) -> None:
        """Destroy all that the node has, and leave the executor."""
        if self._executor is not None:
            self._executor._leave(self)
            self._executor = None
        for kept in (getattr(self, name) for name in KEPT):
            for item in list(kept):
                item.destroy()
            kept.clear()
        if self._rosout is not None:
            self._rosout.close()
            run().rosouts.pop(self._logger.name, None)
        self._handle.destroy_when_not_in_use()
        nodes = run().nodes
        if self in nodes:
            nodes.remove(self)

    def _publish_event(self, event: Any) -> None:
        with self._event_publisher.handle:
            self._event_publisher._check_context("Failed to publish")
        if self._event_publisher._publication.subscriptions:
            event.node = self.get_fully_qualified_name()
            self._event_publisher.publish(event)


def _taken_from(executor: Any) -> str:
    """Return in words where the controller takes a node from an executor that is spun."""
    frame = controller_frame()
    place = "" if frame is None else f" at {Path(frame.f_code.co_filename).name}:{frame.f_lineno}"
    return (
        f"the call{place} took it from the {type(executor).__name__} that a thread spins, as with "
        "the real rclpy: rclpy.spin_once and its like give a node to an executor of their own. "
        "Wait there without spinning: by a rate, or by an event that the future's done callback "
        "sets"
    )


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, list | tuple) else value
