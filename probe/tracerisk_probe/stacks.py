"""Which functions of the controller are active, and where each calls the next.

A traced call sets a context variable twice; where a function stands is read from Python's own
frames, and only when a command asks.
"""

from __future__ import annotations

import functools
import inspect
import itertools
import sys
import threading
from contextvars import ContextVar
from types import CodeType, FrameType
from typing import Any, Callable, NamedTuple

MODULE = "<module>"
_COMPREHENSIONS = frozenset({"<listcomp>", "<setcomp>", "<dictcomp>", "<genexpr>"})

AnyFunction = Callable[..., Any]


class Frame(NamedTuple):
    """One activation of a function on the stack of a command."""

    file: str
    """From the root of the controller."""
    name: str
    """The qualified name."""
    activation: int
    """A number that is unique to this call in the process."""
    line: int
    """The line of the `def`; 1 for a module."""
    at: tuple[int, int]
    """Line and column of the call towards the next frame; column 0 where it is not known."""
    root: str | None = None
    """How it came to run where no code of the controller called it."""


class Function:
    """A traced function: its file, name, line of `def` and code."""

    __slots__ = ("code", "file", "line", "name")

    def __init__(self, file: str, name: str, line: int, code: CodeType) -> None:
        self.file = file
        self.name = name
        self.line = line
        self.code = code


class _Base:
    """The bottom of a stack: a root, or what a thread or a future inherited."""

    __slots__ = ("activation", "inherited", "kind")

    def __init__(self, kind: str, inherited: tuple[Frame, ...] = ()) -> None:
        self.kind = kind
        self.inherited = inherited
        self.activation = _next_activation()


# A link is (the caller's link or the base, the function, the activation): one a traced call.
_top: ContextVar[Any] = ContextVar("tracerisk_probe_stack", default=None)
_next_activation = itertools.count(1).__next__
_new = tuple.__new__  # a third of the time of `Frame(...)`
_names: dict[tuple[str, int, str], tuple[str, str]] = {}
_lines: dict[tuple[str, str], int] = {}
_places: dict[tuple[int, int], tuple[CodeType, tuple[int, int]]] = {}
_MOST_PLACES = 10_000


def know(code: CodeType, file: str, prefix: str = "") -> None:
    """Know the functions of a module's code by the file and their qualified names."""
    for each in code.co_consts:
        if isinstance(each, CodeType):
            name = prefix + each.co_name
            _names[each.co_filename, each.co_firstlineno, each.co_name] = (file, name)
            # What stands in a class is its attribute; the optimised are functions.
            inner = f"{name}.<locals>." if each.co_flags & inspect.CO_OPTIMIZED else f"{name}."
            know(each, file, inner)
    if not prefix:
        _names[code.co_filename, code.co_firstlineno, MODULE] = (file, MODULE)


def traced(file: str, name: str, line: int) -> Callable[[AnyFunction], AnyFunction]:
    """Return the decorator of a function, whose `def` stands in `line` of `file`."""
    _lines[file, name] = line

    def decorate(function: AnyFunction) -> AnyFunction:
        return _wrapped(function, Function(file, name, line, function.__code__))

    return decorate


def run_module(code: CodeType, namespace: dict[str, Any], file: str) -> None:
    """Execute module-level code as the function `<module>` of `file`."""
    know(code, file)
    caller = _top.get()
    _top.set((caller, Function(file, MODULE, 1, code), _next_activation()))
    try:
        exec(code, namespace)
    finally:
        _top.set(caller)


class Standing:
    """Context manager: the stack stands on a base while it is open."""

    __slots__ = ("_before", "base")

    def __init__(self, base: _Base) -> None:
        self.base = base
        self._before: list[Any] = []

    def __enter__(self) -> None:
        self._before.append(_top.get())
        _top.set(self.base)

    def __exit__(self, *error: Any) -> None:
        _top.set(self._before.pop())


def root(kind: str) -> Standing:
    """Return a context manager in which the controller's code is called by none of its own."""
    return Standing(_Base(kind))


def inherit(frames: tuple[Frame, ...]) -> Standing:
    """Return a context manager in which the stack goes on from that of what created this."""
    return Standing(_Base("thread", frames))


def called_by_root(callback: Any, kind: str) -> Any:
    """Return a callback that runs as a root; to callers the same function."""
    if callback is None or not callable(callback):
        return callback
    if inspect.iscoroutinefunction(callback):

        @functools.wraps(callback)
        async def awaited(*args: Any, **kwargs: Any) -> Any:
            return await _Resumed(callback(*args, **kwargs), _Base(kind))

        return awaited

    @functools.wraps(callback)
    def call(*args: Any, **kwargs: Any) -> Any:
        with root(kind):
            return callback(*args, **kwargs)

    return call


def stack() -> tuple[Frame, ...]:
    """Return the active functions of the running code, the outermost first.

    A lambda stands for the function that wrote it. Empty where no code of the controller runs.
    """
    frames = frames_of_links()
    if frames:
        return frames
    base = _top.get()
    python: FrameType | None = sys._getframe(1)
    while python is not None:
        code = python.f_code
        known = _names.get((code.co_filename, code.co_firstlineno, code.co_name))
        if known is not None:
            break
        python = python.f_back
    else:
        return ()
    file, name = known
    parts = name.split(".<locals>.")
    while parts and parts[-1].startswith("<") and parts != [MODULE]:
        parts.pop()
    kind = base.kind if base is not None else _bare_root()
    activation = base.activation if base is not None else _next_activation()
    own = ".<locals>.".join(parts) or MODULE
    line = 1 if own == MODULE else _lines.get((file, own), python.f_code.co_firstlineno)
    return (Frame(file, own, activation, line, _place(python), kind),)


def frames_of_links() -> tuple[Frame, ...]:
    """Match the links of the stack with Python's frames; the outermost first."""
    links = []
    link = _top.get()
    while type(link) is tuple:
        links.append(link)
        link = link[0]
    base: _Base | None = link
    inherited = base.inherited if base is not None else ()
    frames: list[Frame] = []
    python: FrameType | None = sys._getframe(1)
    for position, (_, function, activation) in enumerate(links):
        frame, called = _find(python, function.code)
        if frame is not None:
            at = _place(called or frame)
            python = frame.f_back
        else:
            at = (function.line, 0)  # it returned, or waits: its context was copied
        kind = None
        if position == len(links) - 1 and not inherited:
            kind = base.kind if base is not None else _bare_root()
        found = (function.file, function.name, activation, function.line, at, kind)
        frames.append(_new(Frame, found))
    frames.reverse()
    return (*inherited, *frames)


def _find(python: FrameType | None, code: CodeType) -> tuple[FrameType | None, FrameType | None]:
    """Find the innermost frame that runs `code`, and the comprehension that it runs, if any."""
    inner: FrameType | None = None
    while python is not None and python.f_code is not code:
        inner, python = python, python.f_back
    if (
        python is not None
        and inner is not None
        and inner.f_code.co_name in _COMPREHENSIONS
        and inner.f_code.co_filename == code.co_filename
    ):
        return python, inner
    return python, None


def _place(frame: FrameType) -> tuple[int, int]:
    code, offset = frame.f_code, frame.f_lasti
    known = _places.get((id(code), offset))
    # A code that is gone may have left its number to another one.
    if known is None or known[0] is not code:
        if len(_places) >= _MOST_PLACES:
            _places.clear()
        known = _places[id(code), offset] = (code, _read_place(frame))
    return known[1]


def _read_place(frame: FrameType) -> tuple[int, int]:
    code = frame.f_code
    if sys.version_info >= (3, 11):
        positions = next(itertools.islice(code.co_positions(), frame.f_lasti // 2, None), None)
        if positions is not None and positions[0] is not None:
            column = positions[2]
            return positions[0], 0 if column is None else column + 1
    return frame.f_lineno or code.co_firstlineno, 0


def _bare_root() -> str:
    return "main" if threading.current_thread() is threading.main_thread() else "thread"


def _wrapped(function: AnyFunction, own: Function) -> AnyFunction:
    if inspect.iscoroutinefunction(function):
        wrapper = _coroutine(function, own)
    elif inspect.isasyncgenfunction(function):
        wrapper = _async_generator(function, own)
    elif inspect.isgeneratorfunction(function):
        wrapper = _generator(function, own)
    else:
        wrapper = _plain(function, own)
    return functools.update_wrapper(wrapper, function)


def _plain(function: AnyFunction, own: Function) -> AnyFunction:
    get, put, activation = _top.get, _top.set, _next_activation

    def call(*args: Any, **kwargs: Any) -> Any:
        caller = get()
        put((caller, own, activation()))
        try:
            return function(*args, **kwargs)
        finally:
            put(caller)

    return call


def _generator(function: AnyFunction, own: Function) -> AnyFunction:
    def call(*args: Any, **kwargs: Any) -> Any:
        return (yield from _Resumed(function(*args, **kwargs), own))

    return call


def _coroutine(function: AnyFunction, own: Function) -> AnyFunction:
    async def call(*args: Any, **kwargs: Any) -> Any:
        return await _Resumed(function(*args, **kwargs), own)

    return call


def _async_generator(function: AnyFunction, own: Function) -> AnyFunction:
    async def call(*args: Any, **kwargs: Any) -> Any:
        activation = _next_activation()
        generator = function(*args, **kwargs)
        step = generator.__anext__()
        while True:
            try:
                value = await _Resumed(step, own, activation)
            except StopAsyncIteration:
                return
            try:
                sent = yield value
            except GeneratorExit:
                await _Resumed(generator.aclose(), own, activation)
                raise
            except BaseException as thrown:  # noqa: BLE001 -- it is handed on
                step = generator.athrow(thrown)
            else:
                step = generator.asend(sent)

    return call


class _Resumed:
    """A generator, coroutine or step of an async generator, on the stack when it is resumed.

    `yield from` and `await` hand `send`, `throw` and `close` through to it.
    """

    __slots__ = ("_activation", "_own", "_target")

    def __init__(self, target: Any, own: Any, activation: int = 0) -> None:
        self._target = target
        self._own = own
        self._activation = activation or _next_activation()

    def __iter__(self) -> _Resumed:
        return self

    def __await__(self) -> _Resumed:
        return self

    def _enter(self) -> Any:
        caller = _top.get()
        if isinstance(self._own, _Base):
            _top.set(self._own)
        else:
            _top.set((caller, self._own, self._activation))
        return caller

    def __next__(self) -> Any:
        return self.send(None)

    def send(self, value: Any) -> Any:
        caller = self._enter()
        try:
            return self._target.send(value)
        finally:
            _top.set(caller)

    def throw(self, *error: Any) -> Any:
        caller = self._enter()
        try:
            return self._target.throw(*error)
        finally:
            _top.set(caller)

    def close(self) -> None:
        caller = self._enter()
        try:
            self._target.close()
        finally:
            _top.set(caller)
