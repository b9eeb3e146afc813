"""The screen of `curses` in a run: nothing is drawn on it, and its keys are the typed answers."""

from __future__ import annotations

import _curses
import curses
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from tracerisk.instrument.source.literals.key_codes import CODES, OF_CURSES

ROWS, COLUMNS = 50, 160
"""The size of the screen: large enough for what programs draw [characters]."""
_NO_KEY = -1  # what `getch` returns without one, `ERR`
_POLL_NS = 1_000_000  # what a look for a key takes that does not wait
_SHOWN = frozenset({"has_colors", "can_change_color", "has_ic", "has_il", "is_term_resized"})
_DRAWING = [
    "beep",
    "curs_set",
    "def_prog_mode",
    "def_shell_mode",
    "delay_output",
    "doupdate",
    "echo",
    "endwin",
    "flash",
    "init_color",
    "init_pair",
    "intrflush",
    "meta",
    "mouseinterval",
    "nl",
    "noecho",
    "nonl",
    "noqiflush",
    "noraw",
    "qiflush",
    "raw",
    "reset_prog_mode",
    "reset_shell_mode",
    "resetty",
    "resizeterm",
    "resize_term",
    "savetty",
    "set_escdelay",
    "set_tabsize",
    "setupterm",
    "start_color",
    "typeahead",
    "ungetch",
    "use_default_colors",
    "use_env",
]
"""The functions that change how the terminal behaves or looks: they do nothing."""


class Keyboard(Protocol):
    """What reads keys."""

    def read(self, size: int) -> str:
        """Return what is typed, at most `size` characters."""

    def is_typed(self, timeout_ns: int | None) -> bool:
        """Wait for a key [ns], without an end for None; return whether there is one."""

    def pass_time(self, duration_ns: int) -> None:
        """Wait [ns]."""


@dataclass(slots=True)
class _Terminal:
    """What all windows share."""

    keyboard: Keyboard
    """What reads keys."""
    half_delay_ns: int | None = None
    """For how long a look for a key waits in a window that sets nothing [ns]; `None`: no end."""

    def halfdelay(self, tenths: int) -> None:
        """Set after how many tenths of a second each look for a key ends."""
        self.half_delay_ns = tenths * 100_000_000

    def cbreak(self, flag: bool = True) -> None:
        """Make looks for a key wait without an end again."""
        del flag
        self.half_delay_ns = None

    def napms(self, ms: int) -> None:
        """Wait [ms]."""
        self.keyboard.pass_time(round(ms * 1e6))


class Screen:
    """A window of `curses`, with all methods of the real one."""

    def __init__(self, terminal: _Terminal, rows: int = ROWS, columns: int = COLUMNS) -> None:
        self._terminal = terminal
        self._keyboard = terminal.keyboard
        self._size = rows, columns
        self._timeout_ns: int | None = None

    def nodelay(self, flag: bool) -> None:
        """Make a look for a key wait for one, or not."""
        self._timeout_ns = _POLL_NS if flag else None

    def timeout(self, delay: int) -> None:
        """Set for how long a look for a key waits [ms]; without an end where negative."""
        self._timeout_ns = None if delay < 0 else max(round(delay * 1e6), _POLL_NS)

    def getch(self, *_: int) -> int:
        """Return the code of a key, -1 for none."""
        key = self._key()
        return _NO_KEY if key is None else _code(key)

    def getkey(self, *_: int) -> str:
        """Return a key as a text, or its name; raise the error of curses for none."""
        key = self._key()
        if key is None:
            raise curses.error("no input")
        code = _code(key)
        return curses.keyname(code).decode() if code > 255 else chr(code)

    def get_wch(self, *_: int) -> str | int:
        """Return a character, or the code of another key; raise the error of curses for none."""
        key = self._key()
        if key is None:
            raise curses.error("no input")
        code = _code(key)
        return code if code > 255 else chr(code)

    def getstr(self, *_: int) -> bytes:
        """Return what is typed up to Enter, or one answer."""
        return self._keyboard.read(1_000).rstrip("\r\n").encode()

    def getmaxyx(self) -> tuple[int, int]:
        """Return the number of rows and columns."""
        return self._size

    def _key(self) -> str | None:
        own_ns = self._timeout_ns
        if not self._keyboard.is_typed(self._terminal.half_delay_ns if own_ns is None else own_ns):
            return None
        # The codes of one key are typed at once.
        return self._keyboard.read(_LONGEST)

    def subwin(self, *_: int) -> Screen:
        """Return a window within it."""
        return Screen(self._terminal, *self._size)

    derwin = subpad = subwin

    def __getattr__(self, name: str) -> Any:
        if not hasattr(_curses.window, name):
            raise AttributeError(f"'_curses.window' object has no attribute '{name}'")
        return _PLACES.get(name, _nothing)


_LONGEST = max(map(len, CODES.values()))
_PLACES: Mapping[str, Callable[..., Any]] = {
    "getyx": lambda *_: (0, 0),
    "getbegyx": lambda *_: (0, 0),
    "getparyx": lambda *_: (-1, -1),
    "inch": lambda *_: ord(" "),
    "instr": lambda *_: b"",
    "enclose": lambda *_: True,
    "is_wintouched": lambda *_: False,
    "is_linetouched": lambda *_: False,
    "getbkgd": lambda *_: 0,
}


def screen_functions(keyboard: Keyboard) -> Iterable[tuple[Any, str, Any]]:
    """Return what stands in for functions of `curses`: (module, name, function)."""
    terminal = _Terminal(keyboard)

    def initscr() -> Screen:
        # As the real one, which makes these names known when it knows the terminal.
        for name in _LINES:
            setattr(curses, name, ord("+"))
        curses.LINES, curses.COLS = ROWS, COLUMNS
        return Screen(terminal)

    def window(rows: int = 0, columns: int = 0, *_: int) -> Screen:
        return Screen(terminal, rows or ROWS, columns or COLUMNS)

    def flushinp() -> None:
        """Drop nothing: what is typed is read in its turn."""

    values: Mapping[str, Callable[..., Any]] = {
        "initscr": initscr,
        "newwin": window,
        "newpad": window,
        "flushinp": flushinp,
        "halfdelay": terminal.halfdelay,
        "cbreak": terminal.cbreak,
        "nocbreak": terminal.cbreak,
        "napms": terminal.napms,
        "color_pair": lambda number: number << 8,
        "pair_number": lambda attribute: attribute >> 8,
        "color_content": lambda _: (0, 0, 0),
        "keyname": _key_name,
        "isendwin": lambda: False,
        "termname": lambda: b"xterm",
        "longname": lambda: b"xterm",
        "baudrate": lambda: 38_400,
        "getsyx": lambda: (0, 0),
        "tigetnum": lambda _: -1,
        "tigetflag": lambda _: 0,
        "tigetstr": lambda _: None,
        **dict.fromkeys(_SHOWN, lambda *_: True),
        **dict.fromkeys(_DRAWING, _nothing),
    }
    for name, function in values.items():
        for module in (curses, _curses):
            if hasattr(module, name):
                yield module, name, function


_LINES = [
    f"ACS_{name}"
    for name in [
        "BBSS",
        "BLOCK",
        "BOARD",
        "BSBS",
        "BSSB",
        "BSSS",
        "BTEE",
        "BULLET",
        "CKBOARD",
        "DARROW",
        "DEGREE",
        "DIAMOND",
        "GEQUAL",
        "HLINE",
        "LANTERN",
        "LARROW",
        "LEQUAL",
        "LLCORNER",
        "LRCORNER",
        "LTEE",
        "NEQUAL",
        "PI",
        "PLMINUS",
        "PLUS",
        "RARROW",
        "RTEE",
        "S1",
        "S3",
        "S7",
        "S9",
        "SBBS",
        "SBSB",
        "SBSS",
        "SSBB",
        "SSBS",
        "SSSB",
        "SSSS",
        "STERLING",
        "TTEE",
        "UARROW",
        "ULCORNER",
        "URCORNER",
        "VLINE",
    ]
]


def _key_name(code: int) -> bytes:
    names = (name for name in OF_CURSES if getattr(curses, name) == code)
    return next(names, chr(code)).encode()


def _code(key: str) -> int:
    """Return the code that curses has for a typed key: that of an arrow, or of a character."""
    names = (name for name, plain in OF_CURSES.items() if CODES[plain] == key)
    special = next(names, None) if key.startswith(("\x1b[", "\x1bO")) else None
    return ord(key[0]) if special is None else int(getattr(curses, special))


def _nothing(*_: Any, **__: Any) -> None:
    """Do nothing: nobody sees the screen."""
