"""A terminal at which answers are typed as keys, for a controller that reads one at a time."""

from __future__ import annotations

import os
import select
import termios
import tty
from collections.abc import Callable
from contextlib import AbstractContextManager
from sys import _getframe
from typing import Any

from tracerisk.common.replaced_names import replaced
from tracerisk.errors import Location
from tracerisk.instrument.source.literals.known_keys import known_keys
from tracerisk.ros.controller.frames import controller_stack
from tracerisk.ros.controller.needs import KEYS, Need
from tracerisk.ros.time.scheduler import Scheduler

STDIN = 0
_PRESSED_EACH_NS = 1_000_000_000
_AT_FIRST: list[Any] = [
    termios.ICRNL | termios.IXON,
    termios.OPOST | termios.ONLCR,
    termios.CS8 | termios.CREAD | termios.B38400,
    termios.ICANON | termios.ECHO | termios.ISIG | termios.IEXTEN,
    termios.B38400,
    termios.B38400,
    [b"\0"] * 32,
]
_LOCAL = 3  # the place of the local modes among the attributes


class ScriptedKeys:
    """What stands in for `termios`, `select` and `os.read` at the standard input.

    A controller that has turned off the line mode (`tty.setraw`, `tty.setcbreak`) gets each answer
    as it is, without Enter: a key, or the codes of one. One is pressed a second after the one
    before was read. The need of keys is noted where none is ever pressed.
    """

    def __init__(
        self, next_answer: Callable[[], str | None], scheduler: Scheduler, script: str
    ) -> None:
        self._next_answer = next_answer
        self._scheduler = scheduler
        self._script = script
        self._attributes = _AT_FIRST
        self._typed = ""
        self._is_due = False
        self._was_pressed = False

    @property
    def is_raw(self) -> bool:
        """Whether keys are read one by one, and not lines."""
        return not self._attributes[_LOCAL] & termios.ICANON

    def read(self, size: int) -> str:
        """Return what is typed, at most `size` characters; wait for a key where nothing is.

        Raises:
            RunOver: no key is pressed any more, and nothing else happens.
        """
        self.is_typed(None)
        taken, self._typed = self._typed[:size], self._typed[size:]
        return taken

    def is_typed(
        self,
        timeout_ns: int | None,
        place: Location | None = None,
        is_over: Callable[[], bool] = lambda: False,
    ) -> bool:
        """Wait for a key for so long, without an end for None, and return whether there is one.

        `place` is where the controller compares it, if that is not where it asks. It waits no
        longer once it `is_over`.

        Raises:
            RunOver: no key is pressed any more, and nothing else happens.
        """
        self._look(place)
        self._scheduler.wait_until(
            lambda: bool(self._typed) or is_over(),
            timeout_ns=timeout_ns,
            reason="a key",
            kind="idle",
        )
        return bool(self._typed)

    def pass_time(self, duration_ns: int) -> None:
        """Wait in simulated time [ns]."""
        self._scheduler.sleep(duration_ns)

    def _look(self, place: Location | None = None) -> None:
        """Ask for the next key, which is pressed soon."""
        if self._typed or self._is_due:
            return
        answer = self._next_answer()
        if answer is not None:
            self._is_due = self._was_pressed = True
            due_ns = self._scheduler.now_ns + _PRESSED_EACH_NS
            self._scheduler.call_at(due_ns, lambda: self._press(answer))
        elif not self._was_pressed:
            need = Need("input", KEYS)
            self._scheduler.needs.miss(need, self._scheduler.now_ns, place or self._place())

    def _press(self, answer: str) -> None:
        self._typed, self._is_due = answer, False

    def _place(self) -> Location | None:
        """Return where the controller asks, in its own file or else in one that compares keys."""
        stack = [place for place, _ in controller_stack(_getframe())]
        own = [place for place in stack if place.file == self._script][-1:]
        likely = [*own, *reversed(stack)]
        return next(filter(known_keys, likely), likely[0] if likely else None)

    def served(self) -> AbstractContextManager[None]:
        """Stand in for the functions of a terminal."""
        functions: list[tuple[Any, str, Any]] = [
            (os, "read", self._read_bytes(os.read)),
            (select, "select", self._select(select.select)),
        ]
        for module in (termios, tty):
            functions += [
                (module, "tcgetattr", self._at_stdin(self._get, termios.tcgetattr)),
                (module, "tcsetattr", self._at_stdin(self._set, termios.tcsetattr)),
                (module, "tcflush", self._at_stdin(_nothing, termios.tcflush)),
                (module, "tcdrain", self._at_stdin(_nothing, termios.tcdrain)),
            ]
        return replaced(functions)

    def _at_stdin(self, ours: Callable[..., Any], real: Callable[..., Any]) -> Callable[..., Any]:
        def function(file: Any, /, *arguments: Any) -> Any:
            return (ours if _is_stdin(file) else real)(file, *arguments)

        return function

    def _get(self, _file: Any) -> list[Any]:
        return [
            list(attribute) if isinstance(attribute, list) else attribute
            for attribute in self._attributes
        ]

    def _set(self, _file: Any, _when: int, attributes: list[Any]) -> None:
        if not isinstance(attributes, list) or len(attributes) != len(_AT_FIRST):
            raise TypeError("tcsetattr, arg 3: must be 7 element list")
        self._attributes = [*attributes]

    def _read_bytes(self, real: Callable[[int, int], bytes]) -> Callable[[int, int], bytes]:
        def read(descriptor: int, length: int, /) -> bytes:
            if descriptor == STDIN and self.is_raw and self._scheduler.current is not None:
                return self.read(length).encode()
            return real(descriptor, length)

        return read

    def _select(self, real: Callable[..., Any]) -> Callable[..., Any]:
        def select_(
            read: Any, write: Any, exceptional: Any, timeout: float | None = None, /
        ) -> Any:
            keyboards = [item for item in read if _is_stdin(item)]
            if not keyboards or not self.is_raw or self._scheduler.current is None:
                return real(read, write, exceptional, timeout)
            others = [item for item in read if item not in keyboards]
            if others or write or exceptional:
                self._look()
                result = real(others, write, exceptional, 0)
                return ([*(keyboards if self._typed else ()), *result[0]], *result[1:])
            timeout_ns = None if timeout is None else round(timeout * 1e9)
            return (keyboards if self.is_typed(timeout_ns) else [], [], [])

        return select_


def _is_stdin(file: Any) -> bool:
    if isinstance(file, int):
        return file == STDIN
    try:
        return bool(file.fileno() == STDIN)
    except (AttributeError, OSError, ValueError):
        return False


def _nothing(_file: Any, *_arguments: Any) -> None:
    """Do nothing: what is typed is read in its turn."""
