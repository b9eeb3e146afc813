"""Which instance of a state or behaviour runs, read from Python's own frames.

State machines and behaviour trees (smach, py_trees, FlexBE, YASMIN, and those that a controller
brings along) are objects whose class derives from one called `...State` or `...Behaviour`. One
entered by its machine is known by the key under which the machine holds it, else by its own name.
"""

from __future__ import annotations

import inspect
import re
from types import FrameType
from typing import Any

from tracerisk.common.instance_name import plain_label
from tracerisk.instrument.hidden_frames import is_hidden

_BASE = re.compile(r"\w*(State|Behaviou?r)")
_NAMES = ("name", "_name", "label", "_label")
_MACHINES_OF_OURS = "/stand_ins/smach"
_MOST_STATES = 1000
_MACHINE_WITHIN = 12  # frames above a state's own, the machine's frame among them


class StateEntries:
    """The states on one stack, noted from the innermost frame to the outermost."""

    def __init__(self) -> None:
        self._found: list[tuple[Any, str] | None] = []

    def unknown(self) -> None:
        """Note a function whose frame is gone."""
        self._found.append(None)

    def passed(self, inner: FrameType | None, frame: FrameType, name: str) -> None:
        """Note a function by its frame; `inner` is the innermost frame below it."""
        own = _state_of(frame) if "." in name else None
        if own is None and not self._found:
            # A state of a library's own class commands in the name of the machine's caller.
            while inner is not None and inner is not frame and own is None:
                own = _state_of(inner)
                if own is not None:
                    frame = inner
                inner = inner.f_back
        self._found.append(None if own is None else (own, _label(own, frame)))

    def labels(self, inherited: str | None) -> list[str | None]:
        """Return the label of each function that entered a state, `None` for the others.

        `inherited` is the label of the state from which a thread was started.
        """
        labels: list[str | None] = []
        last: Any = None
        for result in reversed(self._found):
            if result is None:
                labels.append(None)
                continue
            state, label = result
            is_new = state is not last and not (last is None and inherited and label == inherited)
            labels.append(label if is_new else None)
            last = state
        return labels[::-1]


def _state_of(frame: FrameType) -> Any:
    """Return the object whose method a frame runs, if it is a state or behaviour."""
    file = frame.f_code.co_filename
    if is_hidden(file) and _MACHINES_OF_OURS not in file:
        return None
    own = _first_argument(frame)
    kind = type(own)
    if kind is type or not any(_BASE.fullmatch(item.__name__) for item in kind.__mro__[1:]):
        return None
    return own


def _first_argument(frame: FrameType) -> Any:
    code = frame.f_code
    return frame.f_locals.get(code.co_varnames[0]) if code.co_argcount else None


def _label(state: Any, frame: FrameType) -> str:
    """Return what an instance is called; empty where nobody says."""
    above = frame.f_back
    for _ in range(_MACHINE_WITHIN):
        if above is None:
            break
        machine = _first_argument(above)
        key = _key_in(machine, state) if machine is not state else None
        if key:
            return plain_label(key)
        above = above.f_back
    for name in _NAMES:
        text = inspect.getattr_static(state, name, None)
        if isinstance(text, str) and plain_label(text):
            return plain_label(text)
    return ""


def _key_in(machine: Any, state: Any) -> str | None:
    """Return the key under which an object holds a state: itself, or in a description of it."""
    try:
        # Its own `__getattr__` would be code of the controller.
        attributes = object.__getattribute__(machine, "__dict__")
    except AttributeError:
        return None
    for held in list(attributes.values()):
        if not isinstance(held, dict) or len(held) > _MOST_STATES:
            continue
        for key, value in list(held.items()):
            is_state = value is state or (
                isinstance(value, dict) and any(item is state for item in value.values())
            )
            if is_state and isinstance(key, str):
                return key
    return None
