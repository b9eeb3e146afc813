"""Stand-in for pynput.keyboard: a listener hears each answer as a key, pressed and released."""

from __future__ import annotations

import enum
import threading
import time
from collections.abc import Callable
from typing import Any

from tracerisk.instrument.source.literals.key_codes import CODES
from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.keyboard.scripted_keys import ScriptedKeys

__all__ = ["Key", "KeyCode", "Listener"]

_HELD_S = 0.3  # for how long a key is held [s]
_MOST = max(map(len, CODES.values()))


class KeyCode:
    """A key that is a character, or known by a number."""

    def __init__(self, vk: int | None = None, char: str | None = None, **_: Any) -> None:
        self.vk = vk
        self.char = char
        self.is_dead = False

    @classmethod
    def from_char(cls, char: str, **named: Any) -> KeyCode:
        """Return the key of a character."""
        return cls(char=char, **named)

    @classmethod
    def from_vk(cls, vk: int, **named: Any) -> KeyCode:
        """Return the key of a number."""
        return cls(vk=vk, **named)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, KeyCode):
            return False
        return self.char == other.char and (self.char is not None or self.vk == other.vk)

    def __hash__(self) -> int:
        return hash(repr(self))

    def __repr__(self) -> str:
        return f"<{self.vk}>" if self.char is None else repr(self.char)


_NAMES = (
    *("alt", "alt_l", "alt_r", "alt_gr", "cmd", "cmd_l", "cmd_r", "ctrl", "ctrl_l", "ctrl_r"),
    *("shift", "shift_l", "shift_r", "caps_lock", "num_lock", "scroll_lock", "menu", "pause"),
    *("up", "down", "left", "right", "home", "end", "page_up", "page_down", "insert", "delete"),
    *("backspace", "enter", "esc", "print_screen", "space", "tab"),
    *(f"f{number}" for number in range(1, 13)),
)
Key = enum.Enum("Key", {name: KeyCode(vk=number) for number, name in enumerate(_NAMES, 1)})  # type: ignore[misc]
Key.__doc__ = "A key that is no character; as in the real library it has no `char`."


class Listener(threading.Thread):
    """A thread that calls what a program binds to the press and the release of keys."""

    def __init__(
        self,
        on_press: Callable[..., Any] | None = None,
        on_release: Callable[..., Any] | None = None,
        suppress: bool = False,
        **_: Any,
    ) -> None:
        super().__init__(daemon=True)
        self.suppress = suppress
        self._bound = on_press, on_release
        self._was_stopped = False
        self._place = asking_place()

    @property
    def running(self) -> bool:
        """Whether it listens."""
        return self.is_alive() and not self._was_stopped

    def run(self) -> None:
        """Hear keys until it is stopped, or a callback returns False."""
        keys: ScriptedKeys = current().clients[ScriptedKeys]
        while not self._was_stopped:
            if not keys.is_typed(None, self._place, lambda: self._was_stopped):
                return
            key = _key(keys.read(_MOST))
            self._call(0, key)
            time.sleep(_HELD_S)
            self._call(1, key)

    def _call(self, number: int, key: Any) -> None:
        function = self._bound[number]
        if function is not None and not self._was_stopped and function(key) is False:
            self.stop()

    def stop(self) -> None:
        """Listen no more."""
        self._was_stopped = True

    def wait(self) -> None:
        """Return when it listens, at once."""

    def canonical(self, key: Any) -> Any:
        """Return a key without what modifies it."""
        return key

    def __enter__(self) -> Listener:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


def _key(typed: str) -> Any:
    names = (name for name, code in CODES.items() if code == typed)
    name = next(names, None)
    return KeyCode.from_char(typed[:1]) if name is None else Key[name]
