"""What rclpy knows of one run: contexts, nodes, the executor that `rclpy.spin` uses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.graph.runtime import Runtime, current

from .context import Context

if TYPE_CHECKING:
    from ._action_services import ActionServices
    from .executors import Executor
    from .node import Node


class Run:
    """The state of the library: `run()` gives that of the run that is active."""

    def __init__(self, runtime: Runtime) -> None:
        self.runtime = runtime
        self.scheduler = runtime.scheduler
        self.graph = runtime.graph
        self.tracer: Any = runtime.tracer
        self.actions = runtime.client(Actions)
        self.default_context = Context()
        self.global_executor: Executor | None = None
        self.contexts: list[Context] = []
        self.nodes: list[Node] = []
        self.log_levels: dict[str, int] = {"": 20}
        self.log_places: dict[tuple[Any, ...], Any] = {}
        self.rosout: Any = None
        self.rosouts: dict[str, Any] = {}
        self.unheard_loggers: set[str] = set()
        self.signal_options = 0
        self._action_services: ActionServices | None = None

    def end_contexts(self) -> None:
        """End every context that lives, as a signal does; nobody is called back."""
        for context in self.contexts:
            context._end_at_signal()

    @property
    def action_services(self) -> ActionServices:
        """The services and topics of actions; made when a program first asks for one."""
        if self._action_services is None:
            from ._action_services import ActionServices

            self._action_services = ActionServices(self)
        return self._action_services


def run() -> Run:
    """Return the library's state in the active run."""
    return current().client(Run)
