"""The life between `init` and `shutdown`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import MethodType
from typing import Any
from weakref import WeakMethod

from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.graph.runtime import current

from ._arguments import Arguments, parse_arguments
from ._handle import Handle, check_context


class Context:
    """What nodes live in; it is valid from `init` until `shutdown`."""

    def __init__(self) -> None:
        self._is_valid = False
        self._callbacks: list[Any] = []
        self._arguments = Arguments()
        self._domain_id = 0
        self._joined_ns: int | None = None
        self.handle: Handle | None = None

    @property
    def is_valid(self) -> bool:
        """Whether the context lives; asking for it moves no clock."""
        return self._is_valid

    @property
    def arguments(self) -> Arguments:
        """What the command line says to all nodes of the context."""
        return self._arguments

    def init(
        self,
        args: Sequence[str] | None = None,
        *,
        initialize_logging: bool = True,
        domain_id: int | None = None,
    ) -> None:
        """Begin; `args` is a command line, by default the program's own.

        Raises:
            RuntimeError: it has begun before, or the command line is malformed.
        """
        if domain_id is not None and domain_id < 0:
            raise RuntimeError(
                f"Domain id ({domain_id}) should not be lower than zero or negative."
            )
        if self.handle is not None:
            raise RuntimeError("Context.init() must only be called once")
        self._domain_id = domain_id or 0
        self._arguments = parse_arguments(current().argv if args is None else args)
        self._is_valid = True
        from ._run import run

        run().contexts.append(self)
        self.handle = Handle()
        for name, level in self._arguments.log_levels:
            from .logging import set_logger_level

            set_logger_level(name, level)

    def _join(self) -> None:
        """Enter the network, with the first node: others find this process from now on."""
        if self._joined_ns is None:
            self._joined_ns = current().graph.carrier.join()

    def ok(self) -> bool:
        """Return whether the context lives."""
        current().scheduler.touch()
        return self._is_valid

    def shutdown(self) -> None:
        """End: everything that waits goes on.

        Raises:
            RuntimeError: it has not begun.
            RCLError: it has ended already.
        """
        if self.handle is None:
            raise RuntimeError("Context must be initialized before it can be shutdown")
        check_context(
            self, "failed to shutdown", "rcl_shutdown already called on the given context"
        )
        self._end()

    def try_shutdown(self) -> None:
        """End, where it has begun and not ended."""
        if self._is_valid:
            self._end()

    def destroy(self) -> None:
        """End, and let nobody use the context any more."""
        self.try_shutdown()
        if self.handle is not None:
            self.handle.destroy_when_not_in_use()

    def on_shutdown(self, callback: Callable[[], None]) -> None:
        """Call `callback` at the end; a method without keeping its object alive.

        Raises:
            TypeError: it cannot be called.
        """
        if not callable(callback):
            raise TypeError("callback should be a callable")
        if self.handle is not None and not self._is_valid:
            callback()
            return
        kept: Any = WeakMethod(callback) if isinstance(callback, MethodType) else callback
        self._callbacks.append(kept)

    def get_domain_id(self) -> int:
        """Return the domain.

        Raises:
            RuntimeError: the context has not begun.
        """
        if self.handle is None:
            raise RuntimeError("Context must be initialized before it can have a domain id")
        return self._domain_id

    def _end_at_signal(self) -> None:
        """End without calling anybody, as the real handler of signals does."""
        if self._is_valid:
            self._callbacks = []
            self._end()

    def _end(self) -> None:
        self._is_valid = False
        if self._joined_ns is not None:
            current().graph.carrier.leave(self._joined_ns)
            self._joined_ns = None
        callbacks, self._callbacks = self._callbacks, []
        for kept in callbacks:
            callback = kept() if isinstance(kept, WeakMethod) else kept
            if callback is not None:
                callback()

    def __enter__(self) -> Context:
        check_with_block()
        self.init()
        return self

    def __exit__(self, *error: object) -> None:
        self.try_shutdown()


def check_with_block() -> None:
    """Raise what Python does where the distribution has no context manager."""
    distro = current().distro
    distro.decided("with-blocks", asking_place())
    if not distro.value("with-blocks"):
        # As Python 3.10 says it, which Humble has.
        raise AttributeError("__enter__")
