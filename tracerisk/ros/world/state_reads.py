"""Where a controller reads joint states: the lines that another order of the joints reaches."""

from __future__ import annotations

from pathlib import Path
from sys import _getframe
from types import CodeType
from typing import Any

from tracerisk.ros.controller.frames import is_library

_VALUES = ("position", "velocity", "effort")
_BY_PLACE = " without the names of its joints"
_MOST_LINES = 20  # of one run: the first say where to look


class StateReads:
    """Notes the lines of a controller that read values of joint states.

    `message_class` is that of the joint states; it is watched as long as the process lives. A
    function that reads the names, too, can put the values in their order: its lines come last.
    """

    def __init__(self, message_class: Any) -> None:
        self._values: dict[tuple[str, int], tuple[CodeType, str]] = {}
        self._name_readers: set[CodeType] = set()
        for name in ("name", *_VALUES):
            setattr(message_class, name, self._watched(name, getattr(message_class, name)))

    def _watched(self, name: str, field: Any) -> property:
        def read(message: Any) -> Any:
            frame = _getframe(1)
            if not is_library(frame.f_code.co_filename):
                self._note(name, frame.f_code, frame.f_lineno)
            return field.__get__(message, type(message))

        def write(message: Any, value: Any) -> None:
            field.__set__(message, value)

        return property(read, write, doc=field.__doc__)

    def _note(self, name: str, code: CodeType, line: int) -> None:
        if name == "name":
            self._name_readers.add(code)
        elif len(self._values) < _MOST_LINES:
            self._values.setdefault((code.co_filename, line), (code, name))

    def places_in(self, root: Path) -> list[tuple[str, str, int]]:
        """Return in words what is read, each with its file below the controller's root and line.

        Those come first that read no names.
        """
        rows: list[tuple[bool, str, str, int]] = []
        for (file, line), (code, name) in self._values.items():
            if not Path(file).is_relative_to(root):
                continue
            has_names = code in self._name_readers
            words = f"{name} of joint states is read" + (" there" if has_names else _BY_PLACE)
            file = Path(file).relative_to(root).as_posix()
            rows.append((has_names, words, file, line))
        rows.sort(key=lambda entry: entry[0])
        return [(words, file, line) for _, words, file, line in rows]
