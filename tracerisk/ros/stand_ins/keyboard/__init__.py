"""Stand-in for keyboard: each answer of the run is a key, pressed and released."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import Any

from pynput.keyboard import Listener  # type: ignore[import-untyped]

__all__ = [
    "KEY_DOWN",
    "KEY_UP",
    "KeyboardEvent",
    "add_hotkey",
    "hook",
    "is_pressed",
    "on_press",
    "on_press_key",
    "on_release",
    "on_release_key",
    "read_event",
    "read_key",
    "remove_hotkey",
    "unhook",
    "unhook_all",
    "wait",
]

KEY_DOWN, KEY_UP = "down", "up"
_LOOK_S = 0.01  # between two looks for a key [s]; a look by itself takes a tenth of it

Callback = Callable[["KeyboardEvent"], Any]


class KeyboardEvent:
    """The press or the release of a key."""

    def __init__(self, event_type: str, name: str) -> None:
        self.event_type = event_type
        self.name = name
        self.time = time.time()

    def __repr__(self) -> str:
        return f"KeyboardEvent({self.name} {self.event_type})"


class _Keys:
    """The keys that are held, and who hears of them; it listens from its first use on."""

    def __init__(self) -> None:
        self.held: set[str] = set()
        self.events: list[KeyboardEvent] = []
        self.hooks: list[tuple[Any, Callback]] = []
        self._listener: Listener | None = None

    def listen(self) -> None:
        if self._listener is None:
            self._listener = Listener(
                lambda key: self._on_event(KEY_DOWN, key), lambda key: self._on_event(KEY_UP, key)
            )
            self._listener.start()

    def _on_event(self, kind: str, key: Any) -> None:
        event = KeyboardEvent(kind, _name(key))
        (self.held.add if kind == KEY_DOWN else self.held.discard)(event.name)
        self.events.append(event)
        for _, callback in tuple(self.hooks):
            callback(event)


_KEYS = _Keys()


def hook(callback: Callback, suppress: bool = False, **_: Any) -> Callable[[], None]:
    """Call back for each press and release; return what ends that."""
    del suppress
    return _bind(callback, callback)


def on_press(callback: Callback, suppress: bool = False) -> Callable[[], None]:
    """Call back for each press."""
    del suppress
    return _bind(callback, lambda event: event.event_type == KEY_DOWN and callback(event))


def on_release(callback: Callback, suppress: bool = False) -> Callable[[], None]:
    """Call back for each release."""
    del suppress
    return _bind(callback, lambda event: event.event_type == KEY_UP and callback(event))


def on_press_key(key: str, callback: Callback, suppress: bool = False) -> Callable[[], None]:
    """Call back for each press of a key."""
    del suppress
    return _bind(key, _of_key(key, KEY_DOWN, callback))


def on_release_key(key: str, callback: Callback, suppress: bool = False) -> Callable[[], None]:
    """Call back for each release of a key."""
    del suppress
    return _bind(key, _of_key(key, KEY_UP, callback))


def add_hotkey(
    hotkey: str, callback: Callable[..., Any], args: Iterable[Any] = (), **_: Any
) -> Callable[[], None]:
    """Call back with `args` where a key, or the last of several, is pressed."""

    def heard(event: KeyboardEvent) -> None:
        if event.event_type == KEY_DOWN and _parts(hotkey) == _KEYS.held:
            callback(*args)

    return _bind(hotkey, heard)


def unhook(remove: Any) -> None:
    """Call back no more what was bound so, a key or what binding it returned."""
    if callable(remove) and not any(remove == bound for bound, _ in _KEYS.hooks):
        remove()
        return
    _KEYS.hooks = [row for row in _KEYS.hooks if row[0] != remove]


remove_hotkey = clear_hotkey = unhook_key = unhook


def unhook_all() -> None:
    """Call nothing back any more."""
    _KEYS.hooks.clear()


unhook_all_hotkeys = remove_all_hotkeys = clear_all_hotkeys = unhook_all


def is_pressed(hotkey: str) -> bool:
    """Return whether a key, or all of several, are held; a look takes a little time."""
    _KEYS.listen()
    time.sleep(_LOOK_S / 10)
    return _parts(hotkey) <= _KEYS.held


def wait(hotkey: str | None = None, **_: Any) -> None:
    """Wait until a key is held, without an end where none is named."""
    while hotkey is None or not is_pressed(hotkey):
        time.sleep(_LOOK_S)


def read_event(suppress: bool = False) -> KeyboardEvent:
    """Return the next press or release."""
    del suppress
    _KEYS.listen()
    _KEYS.events.clear()
    while not _KEYS.events:
        time.sleep(_LOOK_S)
    return _KEYS.events.pop(0)


def read_key(suppress: bool = False) -> str:
    """Return the name of the key that is pressed or released next."""
    return read_event(suppress).name


def _bind(bound: Any, heard: Callback) -> Callable[[], None]:
    _KEYS.listen()
    row = bound, heard
    _KEYS.hooks.append(row)
    return lambda: _KEYS.hooks.remove(row) if row in _KEYS.hooks else None


def _of_key(key: str, kind: str, callback: Callback) -> Callback:
    return lambda event: (
        event.event_type == kind and {event.name} == _parts(key) and callback(event)
    )


def _parts(hotkey: str) -> set[str]:
    names = (part.strip().lower() for part in hotkey.split("+"))
    return {_OTHER_NAMES.get(name, name) for name in names}


_OTHER_NAMES = {"return": "enter", "escape": "esc", "spacebar": "space", " ": "space"}


def _name(key: Any) -> str:
    char = getattr(key, "char", None)
    name = str(key.name).replace("_", " ") if char is None else str(char).lower()
    return _OTHER_NAMES.get(name, name)
