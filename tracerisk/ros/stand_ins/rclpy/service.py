"""Services: callbacks that answer requests."""

from __future__ import annotations

import inspect
from collections import deque
from collections.abc import Callable
from typing import Any, ClassVar

from tracerisk.ros.messages.ros2 import copy_message

from ._entity import Call
from ._run import run
from .callback_groups import CallbackGroup
from .qos import QoSProfile
from .service_introspection import ServiceEnd


class Service(ServiceEnd):
    """Answers requests of one type; made by `Node.create_service`."""

    _root_kind = "service"
    _is_controllers: ClassVar[bool] = True

    def __init__(
        self,
        node: Any,
        srv_type: Any,
        srv_name: str,
        callback: Callable[[Any, Any], Any],
        callback_group: CallbackGroup,
        qos_profile: QoSProfile,
    ) -> None:
        super().__init__(node, srv_type, srv_name, qos_profile, callback_group)
        self.callback = callback
        self._queue: deque[tuple[Any, Callable[[Any], None], int]] = deque()
        self._server = run().graph.services.serve(
            srv_name,
            srv_type._ros_type,
            self._serve,
            node=node.get_fully_qualified_name(),
            is_callback=self._is_controllers,
        )

    def send_response(self, response: Any, header: Callable[[Any], None]) -> None:
        """Send a response to who asked.

        Raises:
            TypeError: the response is of another class.
        """
        if not isinstance(response, self.srv_type.Response):
            raise TypeError(f"Expected {self.srv_type.Response}, got {type(response)}")
        header(copy_message(response))

    def destroy(self) -> None:
        """Stop serving."""
        super().destroy()
        self._server.close()

    def _enqueue(self, request: Any, reply: Callable[[Any], None], number: int = 0) -> None:
        self._queue.append((request, reply, number))

    def _serve(self, request: Any) -> Any:
        # For a caller that is not a client of rclpy: it waits for the executor of the node.
        answers: list[Any] = []
        self._enqueue(request, answers.append)
        run().scheduler.wait_until(
            lambda: bool(answers),
            reason=f"something that spins the node of service {self._full_name}",
            kind="unmet",
        )
        return answers[0]

    def _is_ready(self) -> bool:
        return bool(self._queue)

    def _take(self, executor: Any) -> Call | None:
        if not self._queue:
            return None
        request, reply, number = self._queue.popleft()
        self._introspection.report("REQUEST_RECEIVED", number, request=request)

        async def call() -> None:
            response = self.callback(request, self.srv_type.Response())
            if inspect.isawaitable(response):
                response = await response
            self.send_response(response, reply)
            self._introspection.report("RESPONSE_SENT", number, response=response)

        return call


class LibraryService(Service):
    """A service that every node has: that it is there is no sign of work that may come."""

    _is_controllers = False
