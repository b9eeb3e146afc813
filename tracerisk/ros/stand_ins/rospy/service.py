"""Services, and those who call them."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from typing import Any

from tracerisk.ros.graph.failures import callback_failed
from tracerisk.ros.graph.graph_names import ANY_TYPE
from tracerisk.ros.graph.services import ServiceFailedError, ServiceServer
from tracerisk.ros.messages.ros1_base import Message
from tracerisk.ros.time.rostime import Duration

from . import core
from ._node import node
from .exceptions import ROSException, ROSInterruptException
from .msg import args_kwds_to_message, sent_copy
from .names import _warn_unless_legal, resolve_name
from .rostime import duration_ns

DEFAULT_BUFF_SIZE = 65536


class ServiceException(Exception):
    """A call of a service failed, or a handler says that it cannot answer."""


class _Service:
    """What a service and its proxy have in common."""

    def __init__(self, name: str, service_class: Any) -> None:
        self.resolved_name = resolve_name(name)
        self.service_class = service_class
        self.request_class: Any = service_class._request_class
        self.response_class: Any = service_class._response_class
        self.uri: str | None = None


class Service(_Service):
    """Answer calls of a service with `handler`, each on a thread of its own.

    Raises:
        ServiceException: this node serves the name already.
        ValueError: the name is empty.
    """

    def __init__(
        self,
        name: str,
        service_class: Any,
        handler: Callable[[Any], Any],
        buff_size: int = DEFAULT_BUFF_SIZE,
        error_handler: Callable[..., None] | None = None,
    ) -> None:
        if not name or not isinstance(name, str):
            raise ValueError("service name is not a non-empty string")
        super().__init__(name, service_class)
        _warn_unless_legal(name, 2)
        state = node()
        self.handler = handler
        self.buff_size = buff_size
        if error_handler is not None:
            self.error_handler = error_handler  # type: ignore[method-assign]
        self.done = False
        self.uri = f"{core.ROSRPC}localhost:0"
        known = state.graph.services.find(self.resolved_name)
        if known is not None and known.is_callback:
            raise ServiceException(f"service [{self.resolved_name}] already registered")
        self._server: ServiceServer = state.graph.services.serve(
            self.resolved_name, service_class._type, self._answer, node=state.name
        )

    def error_handler(self, e: BaseException, exc_type: Any, exc_value: Any, tb: Any) -> None:
        """Log what the handler raised."""
        shown = "".join(traceback.format_exception(exc_type, exc_value, tb)).rstrip()
        core.logerr("Error processing request: %s\n%s", e, shown)

    def shutdown(self, reason: str = "") -> None:
        """Stop serving."""
        self.done = True
        self._server.close()

    def spin(self) -> None:
        """Wait until the service or the node shuts down."""
        state = node()
        state.wait(lambda: self.done, None, f"calls of {self.resolved_name}", "idle")

    def _answer(self, sent: Any) -> Any:
        request = sent_copy(sent, self.request_class)
        request._connection_header = {
            "callerid": node().name,
            "service": self.resolved_name,
            "type": self.service_class._type,
        }
        try:
            response = convert_return_to_response(self.handler(request), self.response_class)
            return sent_copy(response, self.response_class)
        except ServiceException as error:
            raise ServiceFailedError(f"service cannot process request: {error}") from error
        except Exception as error:
            entry = error.__traceback__.tb_next if error.__traceback__ is not None else None
            callback_failed(f"the handler of service {self.resolved_name}", error)
            self.error_handler(error, type(error), error, entry)
            raise ServiceFailedError(f"error processing request: {error}") from error


ServiceImpl = Service


def convert_return_to_response(response: Any, response_class: Any) -> Any:
    """Return the response that a handler's return value stands for.

    That is a response, a dictionary of its fields, a list of their values, or the value of the
    only one.

    Raises:
        ServiceException: the value is None or does not fit.
    """
    if isinstance(response, Message) and response._type == response_class._type:
        return response
    try:
        if isinstance(response, dict):
            return response_class(**response)
        if response is None:
            raise ServiceException("service handler returned None")
        if isinstance(response, list | tuple):
            return response_class(*response)
        return response_class(response)
    except AttributeError as error:
        raise ServiceException(f"handler returned invalid value: {error}") from error
    except TypeError as error:
        text = "wrong number of values" if isinstance(response, list | tuple) else "invalid value"
        raise ServiceException(f"handler returned {text}: {error}") from error


class ServiceProxy(_Service):
    """Call a service: `proxy(request)`, or with the request's fields."""

    def __init__(
        self,
        name: str,
        service_class: Any,
        persistent: bool = False,
        headers: dict[str, str] | None = None,
    ) -> None:
        super().__init__(name, service_class)
        self.persistent = persistent
        self.headers = headers
        self.seq = 0
        node().scheduler.needs.note_type("service", self.resolved_name, service_class._type)
        node().graph.services.become_caller(self.resolved_name, service_class._type)

    def wait_for_service(self, timeout: float | Duration | None = None) -> None:
        """Wait until the service is served; see `rospy.wait_for_service`."""
        _wait(self.resolved_name, timeout, self.service_class._type)

    def __call__(self, *args: Any, **kwds: Any) -> Any:
        """Call the service; see `call`."""
        return self.call(*args, **kwds)

    def call(self, *args: Any, **kwds: Any) -> Any:
        """Call the service and return its response.

        Raises:
            ServiceException: nobody serves it, its type is another, or the handler failed.
            SerializationError: a field of the request holds what its type cannot take.
            ROSInterruptException: the node has shut down.
            TypeError: the arguments make no request.
        """
        request = args_kwds_to_message(self.request_class, args, kwds)
        if request._type != self.request_class._type:
            raise TypeError(
                f"request object type [{type(request)}] does not match service type "
                f"[{self.request_class}]"
            )
        state = node()
        state.scheduler.touch()
        server = state.graph.services.find(self.resolved_name, self.service_class._type)
        if server is None:
            state.graph.services.miss(self.resolved_name, self.service_class._type, request)
            raise ServiceException(f"service [{self.resolved_name}] unavailable")
        if server.type_name not in (ANY_TYPE, self.service_class._type):
            raise ServiceException(
                f"unable to connect to service: request from [{state.name}]: types do not match: "
                f"[{self.service_class._type}] vs. [{server.type_name}]"
            )
        self.seq += 1
        sent = sent_copy(request, self.request_class)
        try:
            response = state.graph.services.call(server, sent)
        except ServiceFailedError as error:
            message = str(error).encode()
            raise ServiceException(
                f"service [{self.resolved_name}] responded with an error: {message!r}"
            ) from error
        if response is None:
            if state.is_shutdown:
                raise ROSInterruptException("node shutdown interrupted service call")
            raise ServiceException(f"service [{self.resolved_name}] returned no response")
        return sent_copy(response, self.response_class)

    def close(self) -> None:
        """Close a persistent connection; the next call makes a new one."""


def wait_for_service(service: str, timeout: float | Duration | None = None) -> None:
    """Wait until a service is served.

    Raises:
        ROSException: it is not within `timeout` (seconds or a Duration).
        ROSInterruptException: the node shuts down first.
        ValueError: the timeout is zero.
    """
    _wait(resolve_name(service), timeout, None)


def _wait(name: str, timeout: float | Duration | None, type_name: str | None) -> None:
    state = node()
    timeout_ns = None if timeout is None else duration_ns(timeout)
    if timeout_ns == 0:
        raise ValueError("timeout must be non-zero")
    wait = state.graph.services.wait_for(
        name, type_name=type_name, timeout_ns=timeout_ns, unless=lambda: state.is_shutdown
    )
    if state.is_shutdown:
        raise ROSInterruptException("rospy shutdown")
    if not wait:
        raise ROSException(f"timeout exceeded while waiting for service {name}")
