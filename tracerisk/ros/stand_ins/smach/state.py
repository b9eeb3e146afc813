"""States: what a container executes, with outcomes and the keys of data that it uses."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from .exceptions import InvalidStateError

_INTERFACE = ("_smach_outcomes", "_smach_input_keys", "_smach_output_keys")


def has_smach_interface(obj: Any) -> bool:
    """Return whether something says its outcomes and keys."""
    return all(hasattr(obj, name) for name in _INTERFACE)


def cb_interface(
    outcomes: Sequence[str] = (),
    input_keys: Sequence[str] = (),
    output_keys: Sequence[str] = (),
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return a decorator that notes the outcomes and keys of a callback."""

    def decorate(cb: Callable[..., Any]) -> Callable[..., Any]:
        for name, value in zip(_INTERFACE, (outcomes, input_keys, output_keys), strict=True):
            setattr(cb, name, list(value))
        return cb

    return decorate


class State:
    """One state; its class overrides `execute`."""

    def __init__(
        self,
        outcomes: Iterable[str] = (),
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        io_keys: Iterable[str] = (),
    ) -> None:
        self._outcomes = dict.fromkeys(outcomes)
        self._input_keys = dict.fromkeys((*input_keys, *io_keys))
        self._output_keys = dict.fromkeys((*output_keys, *io_keys))
        self._preempt_requested = False

    def execute(self, ud: Any) -> Any:
        """Do what the state does; return the outcome."""
        raise NotImplementedError

    def register_outcomes(self, new_outcomes: Iterable[str]) -> None:
        """Add outcomes."""
        self._outcomes.update(dict.fromkeys(new_outcomes))

    def get_registered_outcomes(self) -> tuple[str, ...]:
        """Return the outcomes."""
        return tuple(self._outcomes)

    def register_io_keys(self, keys: Iterable[str]) -> None:
        """Add keys that are read and set."""
        keys = list(keys)
        self.register_input_keys(keys)
        self.register_output_keys(keys)

    def register_input_keys(self, keys: Iterable[str]) -> None:
        """Add keys that are read."""
        self._input_keys.update(dict.fromkeys(keys))

    def get_registered_input_keys(self) -> tuple[str, ...]:
        """Return the keys that are read."""
        return tuple(self._input_keys)

    def register_output_keys(self, keys: Iterable[str]) -> None:
        """Add keys that are set."""
        self._output_keys.update(dict.fromkeys(keys))

    def get_registered_output_keys(self) -> tuple[str, ...]:
        """Return the keys that are set."""
        return tuple(self._output_keys)

    def request_preempt(self) -> None:
        """Ask the state to end before its time."""
        self._preempt_requested = True

    def service_preempt(self) -> None:
        """Note that the state ends as it was asked to."""
        self._preempt_requested = False

    def recall_preempt(self) -> None:
        """Take the request back."""
        self._preempt_requested = False

    def preempt_requested(self) -> bool:
        """Return whether the state was asked to end."""
        return self._preempt_requested


class CBState(State):
    """A state that calls a function."""

    def __init__(
        self,
        cb: Callable[..., Any],
        cb_args: Sequence[Any] = (),
        cb_kwargs: dict[str, Any] | None = None,
        outcomes: Iterable[str] = (),
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        io_keys: Iterable[str] = (),
    ) -> None:
        if not callable(cb):
            raise InvalidStateError("a CBState needs a function to call")
        super().__init__(outcomes, input_keys, output_keys, io_keys)
        self._cb = cb
        self._cb_args, self._cb_kwargs = list(cb_args), dict(cb_kwargs or {})
        if has_smach_interface(cb):
            self.register_outcomes(cb._smach_outcomes)  # type: ignore[attr-defined]
            self.register_input_keys(cb._smach_input_keys)  # type: ignore[attr-defined]
            self.register_output_keys(cb._smach_output_keys)  # type: ignore[attr-defined]

    def execute(self, ud: Any) -> Any:
        """Call the function with the data and its own arguments."""
        return self._cb(ud, *self._cb_args, **self._cb_kwargs)
