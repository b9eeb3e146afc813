"""`launch_ros.actions`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from tracerisk.pipeline.launch_files.parameter_text import ParameterTextError
from tracerisk.pipeline.launch_files.records import LaunchParameter, StartedNode
from tracerisk.pipeline.launch_files.stand_ins.launch.action import Action
from tracerisk.pipeline.launch_files.stand_ins.launch.actions.flow import TimerAction
from tracerisk.pipeline.launch_files.stand_ins.launch.actions.processes import ExecuteProcess
from tracerisk.pipeline.launch_files.stand_ins.launch.utilities import text_of
from tracerisk.pipeline.launch_files.stand_ins.launch_ros.parameter_descriptions import (
    ParameterFile,
    evaluate_parameters,
)

_PARAMETERS, _REMAPS, _NAMESPACE = "global_params", "ros_remaps", "ros_namespace"


def joined_namespace(context: Any, own: str) -> str:
    """Return a namespace within that of the launch file, absolute; empty for none."""
    base = str(context.launch_configurations.get(_NAMESPACE, ""))
    if own.startswith("/"):
        return own if own.strip("/") else ""
    parts = [part for part in (*base.split("/"), *own.split("/")) if part]
    return "/" + "/".join(parts) if parts else ""


class Node(ExecuteProcess):
    """A node: a program of a package, and what it is given."""

    def __init__(
        self,
        *,
        executable: Any = None,
        package: Any = None,
        name: Any = None,
        namespace: Any = None,
        exec_name: Any = None,
        parameters: Any = None,
        remappings: Iterable[tuple[Any, Any]] | None = None,
        ros_arguments: Iterable[Any] | None = None,
        arguments: Iterable[Any] | None = None,
        env: Mapping[Any, Any] | None = None,
        additional_env: Mapping[Any, Any] | None = None,
        condition: Any = None,
        node_name: Any = None,
        node_namespace: Any = None,
        node_executable: Any = None,
        **rest: Any,
    ) -> None:
        super().__init__(
            cmd=(), env=env, additional_env=additional_env, condition=condition, **rest
        )
        # The names with `node_` are those of ROS 2 before Foxy.
        self.executable = executable if executable is not None else node_executable
        if self.executable is None:
            raise TypeError("Node() needs an 'executable'")
        self.package = package
        self.name = name if name is not None else node_name
        self.namespace = namespace if namespace is not None else node_namespace
        self.parameters = parameters
        self.remappings = list(remappings or ())
        self.arguments = list(arguments or ())
        self.ros_arguments = list(ros_arguments or ())

    @property
    def node_name(self) -> Any:
        """The name."""
        return self.name

    def execute(self, context: Any) -> Any:
        """Note the node."""
        configurations = context.launch_configurations
        shared: list[LaunchParameter] = configurations.get(_PARAMETERS, [])
        parameters, left_out = evaluate_parameters(context, self.parameters)
        own = [(text_of(context, a), text_of(context, b)) for a, b in self.remappings]
        context.reading.nodes.append(
            StartedNode(
                "" if self.package is None else text_of(context, self.package),
                text_of(context, self.executable),
                None if self.name is None else text_of(context, self.name),
                joined_namespace(
                    context, "" if self.namespace is None else text_of(context, self.namespace)
                ),
                arguments=tuple(text_of(context, argument) for argument in self.arguments),
                ros_arguments=tuple(
                    text_of(context, ros_argument) for ros_argument in self.ros_arguments
                ),
                parameters=(*shared, *parameters),
                remaps=(*configurations.get(_REMAPS, ()), *own),
                environment=self.environment(context),
                left_out=tuple(left_out),
            )
        )


class LifecycleNode(Node):
    """A node with a life cycle."""

    def __init__(self, *, name: Any, namespace: Any, **rest: Any) -> None:
        rest.pop("autostart", None)
        super().__init__(name=name, namespace=namespace, **rest)


class ComposableNodeContainer(Node):
    """A program that loads nodes written in C++."""

    def __init__(self, *, name: Any, namespace: Any, **rest: Any) -> None:
        rest.pop("composable_node_descriptions", None)
        super().__init__(name=name, namespace=namespace, **rest)


class LoadComposableNodes(Action):
    """Nodes written in C++ for a container."""

    def __init__(
        self, *, composable_node_descriptions: Any, target_container: Any, **rest: Any
    ) -> None:
        super().__init__(**rest)


class PushRosNamespace(Action):
    """A namespace for what follows in the scope."""

    def __init__(self, namespace: Any, **rest: Any) -> None:
        super().__init__(**rest)
        self.namespace = namespace

    def execute(self, context: Any) -> Any:
        """Add it to that which holds."""
        space = joined_namespace(context, text_of(context, self.namespace))
        context.launch_configurations[_NAMESPACE] = space


PushROSNamespace = PushRosNamespace


class SetParameter(Action):
    """A parameter of all nodes that follow in the scope."""

    def __init__(self, name: Any, value: Any, **rest: Any) -> None:
        super().__init__(**rest)
        self.name, self.value = name, value

    def execute(self, context: Any) -> Any:
        """Add it."""
        parameters, _ = evaluate_parameters(context, [{self.name: self.value}])
        _add_shared(context, parameters)


class SetUseSimTime(SetParameter):
    """The parameter `use_sim_time` of all nodes that follow in the scope."""

    def __init__(self, value: Any, **rest: Any) -> None:
        super().__init__("use_sim_time", value, **rest)


class SetParametersFromFile(Action):
    """The parameters of a file for all nodes that follow in the scope."""

    def __init__(self, filename: Any, node_name: Any = None, **rest: Any) -> None:
        super().__init__(**rest)
        self.file = ParameterFile(filename)

    def execute(self, context: Any) -> Any:
        """Add them.

        Raises:
            ParameterTextError: the file cannot be read.
        """
        parameters, left_out = evaluate_parameters(context, [self.file])
        _add_shared(context, parameters)
        if left_out:
            raise ParameterTextError(left_out[0][1])


def _add_shared(context: Any, found: list[LaunchParameter]) -> None:
    # A new list: the scopes keep the old one.
    shared = context.launch_configurations.get(_PARAMETERS, [])
    context.launch_configurations[_PARAMETERS] = [*shared, *found]


class SetRemap(Action):
    """A remapping for all nodes that follow in the scope."""

    def __init__(self, src: Any, dst: Any, **rest: Any) -> None:
        super().__init__(**rest)
        self.src, self.dst = src, dst

    def execute(self, context: Any) -> Any:
        """Add it."""
        rule = (text_of(context, self.src), text_of(context, self.dst))
        configurations = context.launch_configurations
        configurations[_REMAPS] = [*configurations.get(_REMAPS, []), rule]


class SetROSLogDir(Action):
    """The folder of log files, of which none is written."""

    def __init__(self, new_log_dir: Any, **rest: Any) -> None:
        super().__init__(**rest)


class RosTimer(TimerAction):
    """Actions after a time of ROS: their time comes at once."""


ROSTimer = RosTimer


class LifecycleTransition(Action):
    """A change of state of nodes with a life cycle."""

    def __init__(self, *, lifecycle_node_names: Any, transition_ids: Any, **rest: Any) -> None:
        super().__init__(**rest)
