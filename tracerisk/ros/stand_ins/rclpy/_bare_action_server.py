"""The client's side of an action server that a program makes of bare services and topics."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ._run import run
from .qos import QoSProfile
from .service import Service
from .task import Future

_CALLS = {"goal": "send_goal", "cancel": "cancel_goal", "result": "get_result"}


class BareActionServer:
    """Asks the three services of an action, and hears its feedback; made when one is there."""

    def __init__(self, node: Any, action_type: Any, name: str) -> None:
        impl = action_type.Impl
        self._impl = impl
        kinds = (impl.SendGoalService, impl.CancelGoalService, impl.GetResultService)
        self._clients = {
            what: node.create_client(kind, f"{name}/_action/{call}")
            for (what, call), kind in zip(_CALLS.items(), kinds, strict=True)
        }
        self._callbacks: dict[bytes, Callable[[Any], Any]] = {}
        self._heard = node.create_subscription(
            impl.FeedbackMessage, f"{name}/_action/feedback", self._hear, QoSProfile(depth=10)
        )
        self._node = node

    @staticmethod
    def is_there(action_type: Any, name: str) -> bool:
        """Return whether the program itself serves all three."""
        impl = action_type.Impl
        kinds = (impl.SendGoalService, impl.CancelGoalService, impl.GetResultService)
        for call, kind in zip(_CALLS.values(), kinds, strict=True):
            server = run().graph.services.find(f"{name}/_action/{call}", kind._ros_type)
            if server is None or not isinstance(getattr(server.handle, "__self__", None), Service):
                return False
        return True

    def send(self, goal_id: Any, goal: Any, feedback: Callable[[Any], Any] | None) -> Future:
        """Send a goal; return the future of the response."""
        if feedback is not None:
            self._callbacks[bytes(goal_id.uuid)] = feedback
        request = self._impl.SendGoalService.Request(goal_id=goal_id, goal=goal)
        return self._ask("goal", request)

    def cancel(self, goal_id: Any) -> Future:
        """Ask for an early end of a goal; return the future of the response."""
        request = self._impl.CancelGoalService.Request()
        request.goal_info.goal_id = goal_id
        return self._ask("cancel", request)

    def result(self, goal_id: Any) -> Future:
        """Ask for the result of a goal; return the future of the response."""
        return self._ask("result", self._impl.GetResultService.Request(goal_id=goal_id))

    def destroy(self) -> None:
        """Ask no more."""
        for client in self._clients.values():
            self._node.destroy_client(client)
        self._node.destroy_subscription(self._heard)

    def _ask(self, what: str, request: Any) -> Future:
        future: Future = self._clients[what].call_async(request)
        return future

    def _hear(self, message: Any) -> None:
        callback = self._callbacks.get(bytes(message.goal_id.uuid))
        if callback is not None:
            callback(message)
