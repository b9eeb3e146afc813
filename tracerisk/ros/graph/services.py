"""The services of one run: who serves them, who asks for them, and the calls."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Missed, Need, asking_place
from tracerisk.ros.controller.node_process import NodeProcess
from tracerisk.ros.graph.failures import answer_failed

if TYPE_CHECKING:
    from tracerisk.ros.graph.graph import Graph

# Served by a library in the controller, for tools: buffers of tf2, servers of parameters, what
# state a lifecycle node is in.
_OF_TOOLS = re.compile(
    r"tf2_msgs/FrameGraph$|dynamic_reconfigure/|rcl_interfaces/|roscpp/|lifecycle_msgs/Get"
)

_Finder = Callable[[str], tuple[str, Callable[[Any], Any], str] | None]


@dataclass(slots=True, eq=False)
class ServiceServer:
    """The server of a service."""

    services: Services
    """The services of the run."""
    name: str
    """The full name of the service."""
    type_name: str
    """The type of the service, `package/Name`."""
    node: str
    """The full name of the node that serves it."""
    handle: Callable[[Any], Any]
    """The function that takes a request and returns the response."""
    is_callback: bool
    """Whether the handler is the controller's, and runs on a thread of its own."""
    place: Location | None = None
    """The line of the controller that made it; `None` where it is not the controller's."""
    is_called: bool = False
    """Whether it was ever called."""
    process: NodeProcess | None = None
    """The node beside the controller that it belongs to; `None` for all others."""
    made_ns: int = 0
    """The simulated time at which it was made [ns]."""
    is_scenario: bool = False
    """Whether a scenario plays it."""

    def close(self) -> None:
        """Stop serving; calls that run go on."""
        self.services.remove(self)


class ServiceFailedError(Exception):
    """A handler could not answer; raised in the caller with what the handler says."""


class Services:
    """The services of the graph of one run; `graph.services`."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._servers: dict[str, ServiceServer] = {}
        self._callers: dict[Need, Missed] = {}
        self._sought_ns: dict[str, int] = {}
        self._offers: dict[str, dict[str, tuple[Callable[[Any], Any], str]]] = {}
        self._finders: list[_Finder] = []

    def __iter__(self) -> Iterator[ServiceServer]:
        """Yield all servers, in the order in which their names were first served."""
        yield from self._servers.values()

    def serve(
        self,
        name: str,
        type_name: str,
        handle: Callable[[Any], Any],
        *,
        node: str,
        is_callback: bool = True,
        is_scenario: bool = False,
    ) -> ServiceServer:
        """Answer calls of a service; a later server of the name takes the place of the first.

        With `is_callback` the handler runs as a root on a thread of its own; without, on the
        caller's thread: the twin's services.
        """
        place = asking_place() if is_callback else None
        server = ServiceServer(self, name, type_name, node, handle, is_callback, place)
        server.process = self._graph.scheduler.process if is_callback else None
        server.made_ns = self._graph.carrier.made_ns(by_controller=is_callback)
        server.is_scenario = is_scenario
        self._servers[name] = server
        self._graph.report("served", name, type_name)
        return server

    def offer(
        self, base_name: str, type_name: str, handle: Callable[[Any], Any], *, node: str
    ) -> None:
        """Serve `base_name` in whatever namespace somebody asks for it: a service of the twin's.

        A name that many use comes with the part before it: `motion/move_stop`.
        It begins when it is first asked for by name, and where nobody else serves that name.
        Who offers a name and type first serves it. Where several types are offered under one name,
        whoever asks says which is meant.
        """
        self._offers.setdefault(base_name, {}).setdefault(type_name, (handle, node))

    def offer_found(self, finder: _Finder) -> None:
        """Serve what `finder` returns for a name that nobody serves or offers.

        It returns type, handler and node, or None for a name that is none of its own.
        """
        self._finders.append(finder)

    def find(self, name: str, type_name: str | None = None) -> ServiceServer | None:
        """Return who serves a name, if anybody; a service of the twin's begins with that.

        One of another type than whoever asks means does not: many drivers have a `get_state`.
        One of the cell's that the controller is not connected to yet does not either.
        """
        server = self._server(name, type_name)
        return server if server is not None and self._is_found(server) else None

    def _is_found(self, server: ServiceServer) -> bool:
        """Return whether the controller has found a server of the cell."""
        if server.is_callback and server.process is self._graph.scheduler.process:
            return True
        return self._found_ns(server) <= self._graph.scheduler.now_ns

    def _found_ns(self, server: ServiceServer) -> int:
        """Return when the controller finds a server of the cell, or of a companion [ns]."""
        if server.is_callback:
            made_ns = max(server.made_ns, self._sought_ns.get(server.name, 0))
            return self._graph.carrier.own_connected_ns(made_ns, "service client")
        if server.name in self._sought_ns:
            sought_ns = self._sought_ns[server.name]
            return self._graph.carrier.connected_ns(server.name, sought_ns, "service client")
        # The master knows all that a node serves once that has started.
        return self._graph.carrier.connected_ns(server.node, 0, "service client")

    def _wake_when_found(self, name: str, type_name: str | None) -> None:
        """Wake whoever waits for a service when the controller finds its server."""
        server = self._server(name, type_name)
        if server is not None and not self._is_found(server):
            self._graph.carrier.expect(self._found_ns(server))
            self._graph.scheduler.call_at(self._found_ns(server), lambda: None)

    def _server(self, name: str, type_name: str | None) -> ServiceServer | None:
        known = self._servers.get(name)
        parts = name.rsplit("/", 2)
        offered = {
            **self._offers.get("/".join(parts[-2:]), {}),
            **self._offers.get(parts[-1], {}),
        }
        if known is None and offered and (type_name is None or type_name in offered):
            kind = next(iter(offered)) if type_name is None else type_name
        elif (
            known is not None
            and not known.is_callback
            and known.type_name in offered
            and type_name in offered
            and type_name != known.type_name
        ):
            # Waited for by its name alone, another vendor's was taken for it.
            kind = type_name
        else:
            return self._served_if_found(name) if known is None else known
        handle, node = offered[kind]
        return self.serve(name, kind, handle, node=node, is_callback=False)

    def _served_if_found(self, name: str) -> ServiceServer | None:
        row = next(filter(None, (finder(name) for finder in self._finders)), None)
        if row is None:
            return None
        kind, handle, node = row
        return self.serve(name, kind, handle, node=node, is_callback=False)

    def become_caller(self, name: str, type_name: str, *, connects: bool = False) -> None:
        """Note that the code which runs has a client of a service.

        One that `connects` (ROS 2) has to find the server first; else the master knows it, as soon
        as the cell has started.
        """
        if connects:
            self._sought_ns.setdefault(name, self._graph.carrier.made_ns(by_controller=True))
        self._wake_when_found(name, type_name)
        need = Need("service", name, type_name)
        self._callers.setdefault(need, Missed(need, 0, 0, asking_place()))

    def unserved(self) -> tuple[Missed, ...]:
        """Return the services of which the controller has a client and that nobody serves."""
        return tuple(
            caller
            for need, caller in self._callers.items()
            if caller.location is not None and self._server(need.name, need.type_name) is None
        )

    def uncalled(self) -> tuple[Missed, ...]:
        """Return the controller's own services that nobody has called, not those of companions."""
        return tuple(
            Missed(Need("call", server.name, server.type_name), 0, 0, server.place)
            for server in self._servers.values()
            if server.is_callback
            and server.process is None
            and not server.is_called
            and not _OF_TOOLS.match(server.type_name)
        )

    def served(self) -> tuple[ServiceServer, ...]:
        """Return all servers, sorted by name."""
        return tuple(server for _, server in sorted(self._servers.items()))

    def wait_for(
        self,
        name: str,
        *,
        type_name: str | None = None,
        timeout_ns: int | None = None,
        unless: Callable[[], bool] = lambda: False,
    ) -> bool:
        """Wait until a service is served, and return whether it is.

        False after the timeout, or as soon as `unless` holds.

        Raises:
            RunOver: the run is over; a wait that nothing can end is a deadlock that names the
                service and where the controller waits.
        """
        self._wake_when_found(name, type_name)
        text = f"service {name}" + (f" ({type_name})" if type_name else "")
        self._graph.scheduler.wait_until(
            lambda: self._is_known(name) or unless(),
            timeout_ns=timeout_ns,
            reason=text,
            kind="unmet",
            need=Need("service", name, type_name or ""),
        )
        if not self._is_known(name):
            self.miss(name, type_name or "")
        return self._is_known(name)

    def miss(self, name: str, type_name: str, request: Any = None) -> None:
        """Note that the controller asks for a server that is not there, or not found yet."""
        need = Need("service", name, type_name)
        if self._server(name, type_name or None) is None:
            self._graph.scheduler.miss(need)
            return
        self._graph.scheduler.needs.meet(need)
        what = f"a question for service {name}" if request is None else f"a call of {name}"
        self._graph.carrier.note_early(what, name, "service client", request)

    def meet(self, name: str, type_name: str, request: Any = None) -> None:
        """Note that the controller has found a server that it asks for."""
        self._graph.scheduler.needs.meet(Need("service", name, type_name))
        self._graph.carrier.note_in_time(name, request)

    def _is_known(self, name: str) -> bool:
        known = self._servers.get(name)
        return known is not None and self._is_found(known)

    def call(self, server: ServiceServer, request: Any) -> Any:
        """Call a service and wait for its response.

        Raises:
            RunOver: the run is over.
            BaseException: what the handler raised.
        """
        self._graph.scheduler.raise_if_over()
        server.is_called = True
        cell = self._graph.count(server.name)
        answered = None if cell is None else cell.called(server, request)
        try:
            response = self._answer(server, request)
        except BaseException:
            if answered is not None:
                answered(None)
            raise
        if answered is not None:
            answered(response)
        if not server.is_callback:
            answer_failed(server.name, response)
        return response

    def _answer(self, server: ServiceServer, request: Any) -> Any:
        if not server.is_callback:
            self._graph.carrier.pass_latency(server.name)
            response = server.handle(request)
            self._graph.carrier.pass_latency(server.name)
            return response
        self._graph.scheduler.ask(server.process)
        self._graph.await_first_messages(server.process)
        answer = _Answer()
        thread = self._graph.scheduler.spawn(
            lambda: self._handle(server, request, answer),
            f"service {server.name}",
            inherit=False,
            is_controllers=False,
            process=server.process,
        )
        self._graph.scheduler.wait_until(
            lambda: thread.finished, reason=f"the response of service {server.name}", on=thread
        )
        if answer.error is not None:
            raise answer.error
        return answer.response

    def _handle(self, server: ServiceServer, request: Any, answer: _Answer) -> None:
        root = (
            self._graph.tracer.root("service") if self._graph.tracer is not None else nullcontext()
        )
        try:
            with root:
                answer.response = server.handle(request)
        except Exception as error:  # noqa: BLE001 - the handler's; raised again in its caller
            answer.error = error

    def remove(self, server: ServiceServer) -> None:
        """Take away a server, unless another has taken its place."""
        if self._servers.get(server.name) is server:
            del self._servers[server.name]
            self._graph.report("unserved", server.name, server.type_name)


@dataclass(slots=True)
class _Answer:
    """The outcome of a service call."""

    response: Any = None
    """The response; `None` before there is one."""
    error: Exception | None = None
    """Why the handler could not answer; `None` where it did."""
