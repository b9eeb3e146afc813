"""Sockets between the parts of a controller: a call that would block waits in virtual time.

What one part has sent is there when the next one looks: no moment of real time lies between, in
which all would wait and nothing could happen any more.
"""

from __future__ import annotations

import contextlib
import functools
import os
import select
import struct
from collections.abc import Callable, Iterator
from time import monotonic  # the real one: it is about packets of the system
from typing import Any

from tracerisk.common.sandbox.loopback import is_of_run
from tracerisk.ros.controller.programs import Awaited
from tracerisk.ros.time.processes.programs import is_ready, may_answer
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.time.threads import nanoseconds

# The place of the flags among the arguments of each.
_READING = {
    "recv": 1,
    "recv_into": 2,
    "recvfrom": 1,
    "recvfrom_into": 2,
    "recvmsg": 2,
    "recvmsg_into": 2,
}
_WRITING = {"send": 1, "sendmsg": 2, "sendto": 1}
_PIECE = 65536
_DO_NOT_WAIT = 0x40  # MSG_DONTWAIT
_UNSENT = 0x5411  # SIOCOUTQ: what the other end has not confirmed yet
_LONGEST_ON_ITS_WAY_S = 0.002


def socket_replacements(scheduler: Scheduler) -> Iterator[tuple[Any, str, Any]]:
    """Yield owner, name and value of what waits for the other end of a socket.

    While one of several threads waits the others run: the one that answers may be among them.
    """
    import socket
    from multiprocessing.connection import Connection

    kind = socket.socket
    for name in filter(functools.partial(hasattr, kind), _READING):
        yield kind, name, _waiting(scheduler, getattr(kind, name), select.POLLIN, _READING[name])
    for name in filter(functools.partial(hasattr, kind), _WRITING):
        waiting = _waiting(scheduler, getattr(kind, name), select.POLLOUT, _WRITING[name])
        yield kind, name, _arriving(scheduler, waiting)
    yield kind, "sendall", _sendall(scheduler, kind.sendall)
    yield kind, "accept", _accepting(scheduler, kind.accept)
    for name in ("connect", "connect_ex"):
        yield kind, name, _connecting(scheduler, getattr(kind, name))
    yield socket, "socketpair", _pairing(scheduler, socket.socketpair)
    yield Connection, "_recv", _receiving(scheduler, vars(Connection)["_recv"])
    yield Connection, "_send", _arriving(scheduler, vars(Connection)["_send"])


def _wait(scheduler: Scheduler, descriptor: int, event: int, timeout: float | None = None) -> bool:
    """Wait in virtual time until a file is ready; return whether it is.

    Where neither another thread of the controller nor a program that it has started could make it
    so, there is nothing to wait for here.
    """
    if not _is_answerable(scheduler):
        return True
    return scheduler.wait_until(
        is_ready(descriptor, event),
        timeout_ns=None if timeout is None else nanoseconds(timeout),
        reason="the other end of a socket",
        kind="idle",
        awaited=Awaited(descriptors=(descriptor,), limit_s=timeout),
    )


def _is_answerable(scheduler: Scheduler) -> bool:
    return may_answer(scheduler) or (scheduler.may_wait and len(scheduler.threads) > 1)


def _waiting(
    scheduler: Scheduler, real: Callable[..., Any], event: int, flags_at: int | None = None
) -> Callable[..., Any]:
    def is_told_not_to(args: tuple[Any, ...], kwargs: dict[str, Any]) -> bool:
        given = args[flags_at] if flags_at is not None and len(args) > flags_at else None
        flags = kwargs.get("flags", given)
        return isinstance(flags, int) and bool(flags & _DO_NOT_WAIT)

    @functools.wraps(real)
    def call(self: Any, *args: Any, **kwargs: Any) -> Any:
        timeout = self.gettimeout()
        may_wait = timeout != 0 and self.fileno() >= 0
        if timeout is None:  # where there is one, Python waits for it whatever the flags say
            may_wait = may_wait and not is_told_not_to(args, kwargs)
        if may_wait and not _wait(scheduler, self.fileno(), event, timeout):
            raise TimeoutError("timed out")
        result = real(self, *args, **kwargs)
        if event == select.POLLIN:
            scheduler.programs.received(self.fileno(), scheduler.current)
        return result

    return call


def _sendall(scheduler: Scheduler, real: Callable[..., None]) -> Callable[..., None]:
    """Return what sends piece by piece, so that the other end may read meanwhile."""

    @functools.wraps(real)
    def sendall(self: Any, data: Any, flags: int = 0, /) -> None:
        if self.gettimeout() == 0 or not _is_answerable(scheduler):
            real(self, data, flags)
            return
        with memoryview(data) as view, view.cast("B") as octets:
            sent = 0
            while sent < len(octets):
                sent += self.send(octets[sent : sent + _PIECE], flags)

    return sendall


def _accepting(scheduler: Scheduler, real: Callable[..., Any]) -> Callable[..., Any]:
    waiting = _waiting(scheduler, real, select.POLLIN)

    @functools.wraps(real)
    def accept(self: Any) -> Any:
        connection, address = waiting(self)
        scheduler.programs.accepted(connection.fileno())
        _send_at_once(scheduler, connection)
        return connection, address

    return accept


def _connecting(scheduler: Scheduler, real: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(real)
    def connect(self: Any, address: Any, /) -> Any:
        _send_at_once(scheduler, self)
        scheduler.programs.sent(self.fileno())
        if may_answer(scheduler) and _is_of_network(self):
            # A program that starts may be about to listen.
            scheduler.wait_until(
                lambda: is_of_run("socket.connect", self, address),
                timeout_ns=1,
                reason="a program to listen",
                awaited=Awaited(),
            )
        return real(self, address)

    return connect


def _pairing(scheduler: Scheduler, real: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(real)
    def socketpair(*args: Any, **kwargs: Any) -> Any:
        one, other = real(*args, **kwargs)
        scheduler.programs.paired(one.fileno(), other.fileno())
        return one, other

    return socketpair


def _send_at_once(scheduler: Scheduler, sock: Any) -> None:
    """Send small pieces of a stream at once, before the one in front is confirmed."""
    import socket

    if scheduler.current is not None and _is_of_network(sock):
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


def _receiving(scheduler: Scheduler, real: Callable[..., Any]) -> Callable[..., Any]:
    """Return what reads from a connection of `multiprocessing`, by its descriptor."""

    @functools.wraps(real)
    def receive(self: Any, *args: Any) -> Any:
        _wait(scheduler, self.fileno(), select.POLLIN)
        result = real(self, *args)
        scheduler.programs.received(self.fileno(), scheduler.current)
        return result

    return receive


def _arriving(scheduler: Scheduler, real: Callable[..., Any]) -> Callable[..., Any]:
    """Return what sends and goes on when what it sent is at the other end, or is kept there."""

    @functools.wraps(real)
    def send(self: Any, *args: Any, **kwargs: Any) -> Any:
        result = real(self, *args, **kwargs)
        # An event loop goes on to wait at once, with what it has still to send.
        scheduler.programs.sent(self.fileno(), is_all=not os.get_blocking(self.fileno()))
        if scheduler.current is not None and _is_of_network(self):
            _let_arrive(self.fileno())
        return result

    return send


def _is_of_network(sock: Any) -> bool:
    """Return whether it is a socket of an address; a connection of `multiprocessing` mostly is."""
    import socket

    return getattr(sock, "family", socket.AF_INET) in (socket.AF_INET, socket.AF_INET6)


def _let_arrive(descriptor: int) -> None:
    import fcntl

    until = monotonic() + _LONGEST_ON_ITS_WAY_S
    with contextlib.suppress(OSError):
        while struct.unpack("i", fcntl.ioctl(descriptor, _UNSENT, bytes(4)))[0]:
            if monotonic() > until:
                return
