"""Show a controller its stacks and tracebacks as if it ran without tracerisk.

Three means, from the cheapest up: the wrappers take their entries out of every exception that
passes; their code bears a file name that `warnings` and `logging` skip, as they skip the import
system, when they count `stacklevel`; and, while `hidden_frames` is open, `traceback`, `inspect`,
`sys._getframe` and the exception hooks leave out every frame of tracerisk's own.
What no means reaches: `frame.f_back` followed by hand.
"""

from __future__ import annotations

import inspect
import os
import sys
import threading
import traceback
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from types import FrameType, FunctionType, TracebackType
from typing import Any, TypeVar

import tracerisk
from tracerisk.common.replaced_names import replaced

HIDDEN_FILENAME = "<tracerisk, hidden like importlib._bootstrap>"
"""File name of hidden code; `warnings` and `logging` skip `importlib` with `_bootstrap`."""

_PACKAGE = str(Path(tracerisk.__file__).parent) + os.sep

F = TypeVar("F", bound=Callable[..., Any])


def hide(function: F) -> F:
    """Mark a function's frames as those of the import system."""
    assert isinstance(function, FunctionType)
    function.__code__ = function.__code__.replace(co_filename=HIDDEN_FILENAME)
    return function


def is_hidden(filename: str) -> bool:
    """Return whether a code's file name is one of tracerisk's own."""
    return filename == HIDDEN_FILENAME or filename.startswith(_PACKAGE)


def shed(error: BaseException) -> None:
    """Drop the outermost entries of an exception's traceback that are the wrappers'.

    To be called where the exception is caught, before a bare `raise`, which adds no entry.
    Python 3.10 puts them back at the bare `raise`; there they are only hidden from what prints.
    """
    entry = error.__traceback__
    while entry is not None and entry.tb_frame.f_code.co_filename == HIDDEN_FILENAME:
        entry = entry.tb_next
    error.__traceback__ = entry


def visible_traceback(entry: TracebackType | None) -> TracebackType | None:
    """Return a traceback without tracerisk's frames."""
    entries: list[TracebackType] = []
    while entry is not None:
        if not is_hidden(entry.tb_frame.f_code.co_filename):
            entries.append(entry)
        entry = entry.tb_next
    visible: TracebackType | None = None
    for visible_entry in reversed(entries):
        visible = TracebackType(
            visible, visible_entry.tb_frame, visible_entry.tb_lasti, visible_entry.tb_lineno
        )
    return visible


def hidden_frames() -> AbstractContextManager[None]:
    """Leave tracerisk's frames out of what the standard library shows, until closed.

    Everything is put back on exit, in the state found; may be nested.
    """
    replacements: list[tuple[Any, str, Any]] = [
        *((kind, "__init__", _exception_init(kind)) for kind in _traceback_kinds()),
        (traceback, "extract_tb", _extract(traceback.extract_tb)),
        (traceback, "extract_stack", _extract_stack()),
        (inspect, "stack", _stack()),
        (inspect, "trace", _drop_frames(inspect.trace)),
        (inspect, "getouterframes", _drop_frames(inspect.getouterframes)),
        (inspect, "getinnerframes", _drop_frames(inspect.getinnerframes)),
        (sys, "_getframe", _getframe()),
        (sys, "excepthook", _except_hook(sys.excepthook)),
        (threading, "excepthook", _thread_hook(threading.excepthook)),
    ]
    return replaced(replacements)


def _limited(frames: traceback.StackSummary, limit: int | None, *, last: bool) -> None:
    """Drop the hidden frames, then apply `limit` as `traceback` does.

    `last` says which end counts for a positive limit.
    """
    frames[:] = [frame for frame in frames if not is_hidden(frame.filename)]
    if limit is None:
        limit = getattr(sys, "tracebacklimit", None)
        limit = None if limit is None else max(limit, 0)
    if limit is None:
        return
    if last:
        limit = -limit
    if limit >= 0:
        del frames[limit:]
        if last:
            frames.clear()
    else:
        del frames[:limit]


def _traceback_kinds() -> list[type[traceback.TracebackException]]:
    """Return the classes that read a traceback; backports of later versions add their own."""
    base = traceback.TracebackException
    return [base, *(kind for kind in base.__subclasses__() if "__init__" in vars(kind))]


def _exception_init(kind: type[traceback.TracebackException]) -> Callable[..., None]:
    original = vars(kind)["__init__"]

    def init(
        self: traceback.TracebackException, *args: Any, limit: int | None = None, **kwargs: Any
    ) -> None:
        # sys.maxsize: with None the original would read sys.tracebacklimit before we filter.
        original(self, *args, limit=sys.maxsize, **kwargs)
        _limited(self.stack, limit, last=False)

    return init


def _extract(original: Callable[..., traceback.StackSummary]) -> Callable[..., Any]:
    def extract_tb(tb: TracebackType | None, limit: int | None = None) -> traceback.StackSummary:
        frames = original(tb, limit=sys.maxsize)
        _limited(frames, limit, last=False)
        return frames

    return extract_tb


def _extract_stack() -> Callable[..., Any]:
    original, getframe = traceback.extract_stack, sys._getframe

    def extract_stack(
        f: FrameType | None = None, limit: int | None = None
    ) -> traceback.StackSummary:
        caller = getframe(1) if f is None else f
        # print_stack and format_stack pass the frame of their caller, or leave it to us.
        while f is None and caller.f_code.co_filename == traceback.__file__ and caller.f_back:
            caller = caller.f_back
        frames = original(caller, limit=sys.maxsize)
        _limited(frames, limit, last=True)
        return frames

    return extract_stack


def _stack() -> Callable[..., Any]:
    getframe = sys._getframe

    def stack(context: int = 1) -> list[inspect.FrameInfo]:
        return inspect.getouterframes(getframe(1), context)

    return stack


def _drop_frames(original: Callable[..., list[inspect.FrameInfo]]) -> Callable[..., Any]:
    def frames(*args: Any, **kwargs: Any) -> list[inspect.FrameInfo]:
        return [
            info
            for info in original(*args, **kwargs)
            if not is_hidden(info.frame.f_code.co_filename)
        ]

    return frames


def _getframe() -> Callable[..., FrameType]:
    original = sys._getframe

    def visible_frame(depth: int = 0) -> FrameType:
        frame = original(1)
        for _ in range(depth):
            outer = frame.f_back
            while outer is not None and is_hidden(outer.f_code.co_filename):
                outer = outer.f_back
            if outer is None:
                raise ValueError("call stack is not deep enough")
            frame = outer
        return frame

    return visible_frame


def _make_visible(error: BaseException | None) -> None:
    pending, seen = [error], set()
    while pending:
        each = pending.pop()
        if each is None or id(each) in seen:
            continue
        seen.add(id(each))
        each.__traceback__ = visible_traceback(each.__traceback__)
        pending += [each.__cause__, each.__context__]
        # An exception group; Python 3.10 has them from a package.
        pending += getattr(each, "exceptions", ())


def _except_hook(original: Callable[..., Any]) -> Callable[..., Any]:
    def excepthook(
        kind: type[BaseException], error: BaseException, entry: TracebackType | None
    ) -> None:
        _make_visible(error)
        original(kind, error, visible_traceback(entry))

    return excepthook


def _thread_hook(original: Callable[..., Any]) -> Callable[..., Any]:
    def excepthook(args: threading.ExceptHookArgs) -> None:
        _make_visible(args.exc_value)
        visible = visible_traceback(args.exc_traceback)
        original(threading.ExceptHookArgs((args.exc_type, args.exc_value, visible, args.thread)))

    return excepthook
