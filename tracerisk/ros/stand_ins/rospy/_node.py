"""The state of the one rospy node of a process; it lives in the run's `Runtime`."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from tracerisk.ros.controller.needs import Need
from tracerisk.ros.graph import graph_names
from tracerisk.ros.graph.runtime import Runtime, current

if TYPE_CHECKING:
    from .topics import _PublisherImpl, _SubscriberImpl


class NodeState:
    """Names, flags, hooks and endpoints of the node."""

    def __init__(self, runtime: Runtime) -> None:
        self.runtime = runtime
        self.scheduler = runtime.scheduler
        self.graph = runtime.graph
        self.mappings = graph_names.load_mappings(runtime.argv)
        space = self.mappings.get("__ns", os.environ.get("ROS_NAMESPACE", graph_names.SEP))
        self.namespace = graph_names.make_global(space)
        self.name = self.namespace + "unnamed"
        self.resolved_mappings: dict[str, str] = {}
        self.is_initialized = False
        self.is_time_initialized = False
        self.has_simulated_time = False
        """Whether its time is that of a simulation, of which sleeps know the end of the node."""
        self.uri: str | None = None
        """Another than the usual one."""
        self.init_args: tuple[Any, ...] | None = None
        self.is_shutdown = False
        self.is_shutdown_requested = False
        self.client_hooks: list[Callable[[], object]] = []
        self.preshutdown_hooks: list[Callable[[str], object]] = []
        self.shutdown_hooks: list[Callable[[str], object]] = []
        self.publishers: dict[str, _PublisherImpl] = {}
        self.subscribers: dict[str, _SubscriberImpl] = {}
        self.log_level = 2
        self.logged_once: set[tuple[str, int, int]] = set()
        self.logged_at: dict[tuple[str, int, int], int] = {}
        self.logged_text: dict[tuple[str, int, int], str] = {}
        self.rosout: Any = None
        self.scheduler.exit_calls.at_exit(self.scheduler.bound(_shut_down))

    def set_name(self, name: str) -> None:
        """Take a resolved name, and resolve the remappings with it."""
        self.name = name
        self.namespace = graph_names.namespace(name)
        self.resolved_mappings = {
            old if old.startswith("__") else graph_names.resolve(old, name): (
                new if old.startswith("__") else graph_names.resolve(new, name)
            )
            for old, new in self.mappings.items()
        }

    def wait(
        self,
        predicate: Callable[[], bool],
        timeout_ns: int | None,
        reason: str,
        kind: Any = "blocked",
        need: Need | None = None,
    ) -> bool:
        """Wait until `predicate` holds or the node shuts down; return whether it holds."""
        self.scheduler.wait_until(
            lambda: self.is_shutdown or predicate(),
            timeout_ns=timeout_ns,
            reason=reason,
            kind=kind,
            need=need,
        )
        return predicate()


def _shut_down() -> None:
    from .core import signal_shutdown

    signal_shutdown("atexit")


def node() -> NodeState:
    """Return the state of the node of the active run."""
    return current().client(NodeState)
