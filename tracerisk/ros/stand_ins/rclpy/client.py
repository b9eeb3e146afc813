"""Clients of services."""

from __future__ import annotations

from collections import deque
from typing import Any

from tracerisk.ros.controller.needs import Need, asking_place
from tracerisk.ros.graph.graph_names import ANY_TYPE
from tracerisk.ros.graph.services import ServiceFailedError, ServiceServer
from tracerisk.ros.messages.ros2 import copy_message

from ._entity import Call
from ._handle import check_context
from ._run import run
from .callback_groups import CallbackGroup
from .qos import QoSProfile
from .service import Service
from .service_introspection import ServiceEnd
from .task import Future


class Client(ServiceEnd):
    """Calls a service of one type; made by `Node.create_client`.

    A response completes its future when an executor takes it.
    """

    def __init__(
        self,
        node: Any,
        srv_type: Any,
        srv_name: str,
        qos_profile: QoSProfile,
        callback_group: CallbackGroup,
    ) -> None:
        super().__init__(node, srv_type, srv_name, qos_profile, callback_group)
        self.context = node.context
        self._n_calls = 0
        self._pending: list[Future] = []
        self._responses: deque[tuple[Future, Any, int]] = deque()
        run().graph.services.become_caller(srv_name, srv_type._ros_type, connects=True)
        run().graph.carrier.pass_work("end")

    def call(self, request: Any, *timeout: float | None, **named: float | None) -> Any:
        """Call the service and wait for the response; another thread has to spin.

        The only other argument is `timeout_sec`; without a response in time the result is None.

        Raises:
            TypeError: the request is of another class, or the distribution takes no timeout.
        """
        timeout_sec = self._timeout_sec(*timeout, **named)
        self._check(request)
        future = self.call_async(request)
        run().scheduler.wait_until(
            lambda: future._done,
            timeout_ns=None if timeout_sec is None else round(timeout_sec * 1e9),
            reason=self._text,
            kind=self._meaning_of_answer,
        )
        if not future._done:
            self.remove_pending_request(future)
        return future.result()

    def _timeout_sec(self, *given: float | None, **named: float | None) -> float | None:
        if not given and not named:
            return None
        distro = run().runtime.distro
        distro.decided("call-with-timeout", asking_place())
        takes_it = bool(distro.value("call-with-timeout"))
        return (_with_timeout if takes_it else _without_timeout)(*given, **named)

    def call_async(self, request: Any) -> Future:
        """Call the service and return the response's future.

        Raises:
            TypeError: the request is of another class.
            AssertionError: a field holds what does not fit.
        """
        self._check(request)
        future = Future(waits_for=self._text, source=self)
        self._pending.append(future)
        future.add_done_callback(self.remove_pending_request)
        sent = copy_message(request)
        self._n_calls += 1
        number = self._n_calls
        self._introspection.report("REQUEST_SENT", number, request=sent)
        server = self._server()
        if server is None:
            # Lost, as on a network: who serves later never hears of it.
            run().graph.services.miss(self._full_name, self.srv_type._ros_type, sent)
            return future
        run().graph.services.meet(self._full_name, self.srv_type._ros_type, sent)
        service = getattr(server.handle, "__self__", None)
        if isinstance(service, Service):
            server.is_called = True
            run().scheduler.ask(server.process)
            service._enqueue(
                sent, lambda response: self._responses.append((future, response, number)), number
            )
        else:
            # The twin's: it acts on behalf of the code that calls here.
            run().scheduler.spawn(
                lambda: self._call_other(server, sent, future, number),
                f"call of {self._full_name}",
                is_controllers=False,
            )
        return future

    def _call_other(self, server: ServiceServer, request: Any, future: Future, number: int) -> None:
        try:
            response = run().graph.services.call(server, request)
        except ServiceFailedError as error:
            self._node.get_logger().error(f"service {self._full_name}: {error}")
            return
        self._responses.append((future, response, number))

    def get_pending_requests(self) -> list[Future]:
        """Return the futures of the calls that have no response."""
        return list(self._pending)

    def remove_pending_request(self, future: Future) -> None:
        """Forget a call; its response is dropped."""
        if future in self._pending:
            self._pending.remove(future)

    def service_is_ready(self) -> bool:
        """Return whether somebody serves.

        Raises:
            InvalidHandle: the client was destroyed.
            RCLError: the context was shut down.
        """
        with self.handle:
            check_context(self.context, "failed to check service availability")
        run().scheduler.touch()
        is_ready, graph = self._server() is not None, run().graph
        note = graph.services.meet if is_ready else graph.services.miss
        note(self._full_name, self.srv_type._ros_type)
        return is_ready

    def wait_for_service(self, timeout_sec: float | None = None) -> bool:
        """Wait until somebody serves, and return whether somebody does; see `service_is_ready`."""
        run().scheduler.wait_until(
            lambda: self._server() is not None or not self.context.is_valid,
            timeout_ns=None if timeout_sec is None else max(0, round(timeout_sec * 1e9)),
            reason=f"service {self._full_name} ({self.srv_type._ros_type})",
            kind="unmet",
            need=self._need,
        )
        return self.service_is_ready()

    def destroy(self) -> None:
        """Make no more calls."""
        super().destroy()
        self._responses.clear()

    @property
    def _text(self) -> str:
        return f"the response of service {self._full_name} ({self.srv_type._ros_type})"

    @property
    def _need(self) -> Need:
        return Need("service", self._full_name, self.srv_type._ros_type)

    def _check(self, request: Any) -> None:
        if not isinstance(request, self.srv_type.Request):
            raise TypeError(f"Expected {self.srv_type.Request}, got {type(request)}")
        with self.handle:
            return

    def _server(self) -> ServiceServer | None:
        server = run().graph.services.find(self._full_name, self.srv_type._ros_type)
        if server is None or server.type_name not in (ANY_TYPE, self.srv_type._ros_type):
            return None
        return server

    def _is_ready(self) -> bool:
        return bool(self._responses)

    def _take(self, executor: Any) -> Call | None:
        if not self._responses:
            return None
        future, response, number = self._responses.popleft()
        self._introspection.report("RESPONSE_RECEIVED", number, response=response)

        async def call() -> None:
            if future in self._pending:
                future._set_executor(executor)
                future.set_result(response)

        return call


def _with_timeout(timeout_sec: float | None = None) -> float | None:
    return timeout_sec


def _without_timeout() -> None:
    """Take no argument: Python's own error names the one that is too many."""
