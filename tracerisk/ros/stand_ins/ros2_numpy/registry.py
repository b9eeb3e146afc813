"""Which message is made into which array."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

__all__ = ["converts_from_numpy", "converts_to_numpy", "msgify", "numpify"]

_to_numpy: dict[tuple[Any, bool], Callable[..., Any]] = {}
_from_numpy: dict[tuple[Any, bool], Callable[..., Any]] = {}
_Function = Callable[..., Any]


def converts_to_numpy(msgtype: Any, plural: bool = False) -> Callable[[_Function], _Function]:
    """Make a function the one that turns a message into an array."""

    def decorate(function: _Function) -> _Function:
        _to_numpy[msgtype, plural] = function
        return function

    return decorate


def converts_from_numpy(msgtype: Any, plural: bool = False) -> Callable[[_Function], _Function]:
    """Make a function the one that turns an array into a message."""

    def decorate(function: _Function) -> _Function:
        _from_numpy[msgtype, plural] = function
        return function

    return decorate


def numpify(msg: Any, *args: Any, **kwargs: Any) -> Any:
    """Return a message, or a list of one type, as an array; None of None.

    Raises:
        ValueError: no function is known for its type, or a list is empty.
    """
    if msg is None:
        return None
    convert = _to_numpy.get((type(msg), False))
    if convert is None and isinstance(msg, Sequence):
        if not msg:
            raise ValueError("Cannot determine the type of an empty Collection")
        convert = _to_numpy.get((type(msg[0]), True))
    if convert is None:
        raise ValueError(
            f"Unable to convert message {type(msg).__name__} - only supports {_known(_to_numpy)}"
        )
    return convert(msg, *args, **kwargs)


def msgify(msg_type: Any, numpy_obj: Any, *args: Any, **kwargs: Any) -> Any:
    """Return an array as a message of a type.

    Raises:
        ValueError: no function is known for the type.
    """
    convert = _from_numpy.get((msg_type, kwargs.pop("plural", False)))
    if convert is None:
        raise ValueError(
            f"Unable to build message {msg_type.__name__} - only supports {_known(_from_numpy)}"
        )
    return convert(numpy_obj, *args, **kwargs)


def _known(table: dict[tuple[Any, bool], Any]) -> str:
    return ", ".join(kind.__name__ + ("[]" if plural else "") for kind, plural in table)
