"""A launch file that may be the one that starts the controller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tracerisk.pipeline.launch.find import LaunchFile
from tracerisk.pipeline.launch.parameter_files import (
    GivenParameters,
)
from tracerisk.pipeline.launch.parameter_reads import Asked
from tracerisk.pipeline.launch_files.records import (
    EVERY_NODE,
    LaunchParameter,
    LaunchReading,
    StartedNode,
)
from tracerisk.ros.graph import graph_names


@dataclass(frozen=True, slots=True)
class Candidate:
    """A launch file of the controller, with the node that starts it and what it gives this."""

    file: LaunchFile
    """The launch file."""
    reading: LaunchReading
    """All that the launch file starts."""
    node: StartedNode
    """The node of the file that is the controller."""
    started: int
    """How many times the file starts the controller."""
    nodes: tuple[str, ...]
    """The names that the controller's node may have."""

    @property
    def parameters(self) -> tuple[LaunchParameter, ...]:
        """What the node finds of parameters: its own, and those of the server of ROS 1."""
        return (*self.reading.parameters, *self.node.parameters)

    @property
    def own(self) -> dict[str, Any]:
        """The parameters that are meant for the node, by the names it may ask for."""
        if self.file.ros == 2:
            return {
                parameter.name: parameter.value
                for parameter in self.parameters
                if self._is_for(parameter)
            }
        owner = f"{self.node.namespace}/{self.node.name}/"
        space = f"{self.node.namespace}/"
        table: dict[str, Any] = {}
        for parameter in self.parameters:
            table[parameter.name] = parameter.value
            if parameter.name.startswith(owner):
                table[f"~{parameter.name.removeprefix(owner)}"] = parameter.value
            elif parameter.name.startswith(space):
                table[parameter.name.removeprefix(space)] = parameter.value
        return table

    @property
    def private(self) -> tuple[LaunchParameter, ...]:
        """The parameters that are the node's alone."""
        if self.file.ros == 2:
            return tuple(parameter for parameter in self.parameters if self._is_for(parameter))
        owner = f"{self.node.namespace}/{self.node.name}/"
        return tuple(parameter for parameter in self.parameters if parameter.name.startswith(owner))

    def _is_for(self, parameter: LaunchParameter) -> bool:
        """Return whether a parameter is the node's, which may be any whose name is not known."""
        whom = parameter.node
        if whom in (None, EVERY_NODE) or not self.nodes:
            return True
        assert whom is not None
        return whom.rpartition("/")[2] in (*self.nodes, "*", "**")

    def gives(self, asked: frozenset[str]) -> int:
        """Return how many of the parameters asked for it gives, whole namespaces too."""
        own = self.own
        mark = "." if self.file.ros == 2 else graph_names.SEP
        return sum(
            1
            for name in asked
            if name in own or any(given.startswith(f"{name}{mark}") for given in own)
        )

    def fits(self, given: GivenParameters) -> tuple[int, int]:
        """Return how well it goes with what the controller's own arguments give.

        That is how many of their files, or files beside these, it reads, and how many of their
        values it gives too.
        """
        own = self.own
        values = sum(1 for one in given.parameters if own.get(one.name) == one.value)
        return given.beside(self.reading), values

    def same_as(self, other: Candidate, asked: Asked) -> bool:
        """Return whether the node is given the same by another file."""
        return self._given(asked) == other._given(asked)

    def _given(self, asked: Asked) -> tuple[Any, ...]:
        words = asked.names | asked.literals
        is_ros2 = self.file.ros == 2
        own = {k: v for k, v in self.own.items() if is_ros2 or k.startswith("~") or k in words}
        node = self.node
        return own, node.arguments, node.remaps, node.namespace, node.ros_arguments
