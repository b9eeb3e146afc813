"""The codes that a terminal sends for keys that are no characters, by the names of the keys."""

from __future__ import annotations

from collections.abc import Mapping

CODES: Mapping[str, str] = {
    "up": "\x1b[A",
    "down": "\x1b[B",
    "right": "\x1b[C",
    "left": "\x1b[D",
    "home": "\x1b[H",
    "end": "\x1b[F",
    "insert": "\x1b[2~",
    "delete": "\x1b[3~",
    "page_up": "\x1b[5~",
    "page_down": "\x1b[6~",
    "esc": "\x1b",
    "space": " ",
    "enter": "\n",
    "tab": "\t",
    "backspace": "\x7f",
    "f1": "\x1bOP",
    "f2": "\x1bOQ",
    "f3": "\x1bOR",
    "f4": "\x1bOS",
}
"""The code of each key, as `xterm` sends it (`infocmp xterm`: kcuu1, kpp, kf1 ...)."""

OF_CURSES: Mapping[str, str] = {
    "KEY_UP": "up",
    "KEY_DOWN": "down",
    "KEY_RIGHT": "right",
    "KEY_LEFT": "left",
    "KEY_HOME": "home",
    "KEY_END": "end",
    "KEY_IC": "insert",
    "KEY_DC": "delete",
    "KEY_PPAGE": "page_up",
    "KEY_NPAGE": "page_down",
    "KEY_ENTER": "enter",
    "KEY_BACKSPACE": "backspace",
    "KEY_F1": "f1",
    "KEY_F2": "f2",
    "KEY_F3": "f3",
    "KEY_F4": "f4",
}
"""The names of keys in `curses`."""


def code_of_name(name: str) -> str | None:
    """Return the code of a key by its name in a library: `up`, `KEY_UP`, `K_UP`, `K_w`."""
    if name in OF_CURSES:
        return CODES[OF_CURSES[name]]
    if name.startswith("K_"):
        name = name.removeprefix("K_")
        if len(name) == 1:
            return name
    plain = name.lower().replace("return", "enter").replace("escape", "esc")
    return CODES.get(plain.replace("pageup", "page_up").replace("pagedown", "page_down"))
