"""Goals and requests from the data of a state machine, and results back into it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import smach


class Slots:
    """How a message is filled for a call, and what of the answer is kept.

    `message` is a message or a function that makes one of the data; `key` the data that holds a
    whole one, `slots` fields that are data each, `callback` a function that fills it.
    """

    def __init__(
        self,
        message: Any,
        key: str | None,
        slots: Iterable[str],
        callback: Callable[..., Any] | None,
        args: Sequence[Any],
        kwargs: dict[str, Any] | None,
    ) -> None:
        self.key, self.slots = key, list(slots)
        self._message = message if not callable(message) or isinstance(message, type) else None
        self._callback = callback if self._message is message or callback else message
        self._args, self._kwargs = list(args), dict(kwargs or {})

    @property
    def keys(self) -> list[str]:
        """The data that is read or set."""
        said = list(getattr(self._callback, "_smach_input_keys", ()))
        said += list(getattr(self._callback, "_smach_output_keys", ()))
        return [*([] if self.key is None else [self.key]), *self.slots, *said]

    @property
    def outcomes(self) -> list[str]:
        """The outcomes that the callback adds."""
        return list(getattr(self._callback, "_smach_outcomes", ()))

    def filled(self, data: Any, kind: type) -> Any:
        """Return the message to send."""
        message = kind() if self._message is None else self._message
        if self.key is not None:
            message = data[self.key]
        for slot in self.slots:
            setattr(message, slot, data[slot])
        if self._callback is not None:
            made = self._callback(data, message, *self._args, **self._kwargs)
            message = message if made is None else made
        return message

    def keep(self, data: Any, answer: Any, *status: Any) -> str | None:
        """Put the answer into the data; return the outcome that the callback gives."""
        if self.key is not None:
            data[self.key] = answer
        for slot in self.slots:
            data[slot] = getattr(answer, slot)
        if self._callback is None:
            return None
        outcome = self._callback(data, *status, answer, *self._args, **self._kwargs)
        if outcome is not None and not isinstance(outcome, str):
            raise smach.InvalidUserCodeError(
                f"a result callback returned {outcome!r}, which is no outcome"
            )
        return outcome
