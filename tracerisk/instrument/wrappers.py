"""What stands between a caller and a traced function: one wrapper for each kind of function.

A wrapper puts the function on the stack while its code runs; at a generator or a coroutine again
at each resumption, on the stack of whoever resumes it.
"""

from __future__ import annotations

import contextlib
import functools
import inspect
import sys
from collections.abc import AsyncGenerator, Callable, Generator
from types import CodeType, FrameType, FunctionType
from typing import TYPE_CHECKING, Any

from tracerisk.instrument.hidden_frames import HIDDEN_FILENAME, hide, shed
from tracerisk.instrument.marks.calls import has_marks

if TYPE_CHECKING:
    from tracerisk.instrument.marks.call_log import CallLog
    from tracerisk.instrument.tracer import Tracer

# Bound here: the run may show controllers a `sys._getframe` that hides the tracer's own frames.
_getframe = sys._getframe

# A function that returns more often is called in loops, and its paths repeat; a numeric function
# may be called a million times.
_MOST_TURNS = 1000

AnyFunction = Callable[..., Any]


def wrap(function: AnyFunction, tracer: Tracer, record: Any) -> AnyFunction:
    """Return `function` traced; to callers and to `inspect` the same function.

    One difference: at a generator or a coroutine function, wrong arguments show at the first
    resumption, not at the call.
    """
    if inspect.iscoroutinefunction(function):
        wrapper = _wrap_coroutine(function, tracer, record)
    elif inspect.isasyncgenfunction(function):
        wrapper = _wrap_async_generator(function, tracer, record)
    elif inspect.isgeneratorfunction(function):
        wrapper = _wrap_generator(function, tracer, record)
    else:
        wrapper = _wrap_plain(function, tracer, record)
    assert isinstance(wrapper, FunctionType)
    wrapper.__code__ = _disguised(wrapper.__code__, function.__code__)
    functools.update_wrapper(wrapper, function)
    # getfullargspec() does not follow __wrapped__. NameError: annotations not defined yet (3.14).
    with contextlib.suppress(NameError):
        wrapper.__signature__ = inspect.signature(function)  # type: ignore[attr-defined]
    return wrapper


def _disguised(code: CodeType, original: CodeType) -> CodeType:
    """Name the wrapper's code after the function it wraps, for profilers and `typing.overload`."""
    disguised = code.replace(
        co_filename=HIDDEN_FILENAME,
        co_name=original.co_name,
        co_firstlineno=original.co_firstlineno,
    )
    if sys.version_info >= (3, 11):
        disguised = disguised.replace(co_qualname=original.co_qualname)
    return disguised


def _wrap_plain(function: AnyFunction, tracer: Tracer, record: Any) -> AnyFunction:
    get, put = tracer.top.get, tracer.top.set
    next_activation, returned = tracer.next_activation, tracer.calls.returned
    noted = _MOST_TURNS if has_marks(function.__code__) else 0
    unnoted: set[str] = set()
    ran = False

    def wrapper(*args: Any, **kwargs: Any) -> Any:
        nonlocal ran, noted
        if not ran:
            tracer.first_run(record)
            ran = True
        caller = get()
        executed: set[str] = set() if noted else unnoted
        put((caller, record, next_activation(), executed, ""))
        try:
            result = function(*args, **kwargs)
        except BaseException as error:
            shed(error)
            raise
        finally:
            put(caller)
        if noted:
            noted -= 1
            returned(_getframe(1), record, executed)
        return result

    return wrapper


def _wrap_generator(function: AnyFunction, tracer: Tracer, record: Any) -> AnyFunction:
    def wrapper(*args: Any, **kwargs: Any) -> Generator[Any, Any, Any]:
        activation = _Activation(tracer, record, _getframe())
        try:
            result = yield from _Resumed(function(*args, **kwargs), activation)
        except BaseException as error:
            shed(error)
            raise
        activation.end()
        return result

    return wrapper


def _wrap_coroutine(function: AnyFunction, tracer: Tracer, record: Any) -> AnyFunction:
    async def wrapper(*args: Any, **kwargs: Any) -> Any:
        activation = _Activation(tracer, record, _getframe())
        try:
            result = await _Resumed(function(*args, **kwargs), activation)
        except BaseException as error:
            shed(error)
            raise
        activation.end()
        return result

    return wrapper


def _wrap_async_generator(function: AnyFunction, tracer: Tracer, record: Any) -> AnyFunction:
    async def wrapper(*args: Any, **kwargs: Any) -> AsyncGenerator[Any, Any]:
        activation = _Activation(tracer, record, _getframe())
        generator = function(*args, **kwargs)
        awaitable = generator.__anext__()
        try:
            while True:
                value = await _Resumed(awaitable, activation)
                try:
                    sent = yield value
                except GeneratorExit:
                    await _Resumed(generator.aclose(), activation)
                    raise
                except BaseException as thrown:  # noqa: BLE001 -- it is handed on
                    awaitable = generator.athrow(thrown)
                else:
                    awaitable = generator.asend(sent)
        except StopAsyncIteration:
            activation.end()
            return
        except BaseException as error:
            shed(error)
            raise

    return wrapper


class _Activation:
    """What is the same at each resumption of a generator or a coroutine, which begins now."""

    __slots__ = ("_calls", "rest", "top")

    def __init__(self, tracer: Tracer, record: Any, frame: FrameType) -> None:
        tracer.first_run(record)
        executed: set[str] = set()
        made_at = tracer.calls.begun(frame)
        self._calls: CallLog = tracer.calls
        self.rest = (record, tracer.next_activation(), executed, made_at)
        """Its link of the stack but for the caller's, which differs."""
        self.top = tracer.top

    def end(self) -> None:
        """Note that it came to its end."""
        record, _, executed, made_at = self.rest
        self._calls.ended(made_at, record.ref, executed)


class _Resumed:
    """A generator, a coroutine or one step of an async generator, on the stack at each resumption.

    `yield from` and `await` hand `send`, `throw` and `close` through to it.
    """

    __slots__ = ("_rest", "_target", "_top")

    def __init__(self, target: Any, activation: _Activation) -> None:
        self._target = target
        self._top = activation.top
        self._rest = activation.rest

    def __iter__(self) -> _Resumed:
        return self

    def __await__(self) -> _Resumed:
        return self

    @hide
    def __next__(self) -> Any:
        return self.send(None)

    @hide
    def send(self, value: Any) -> Any:
        caller = self._top.get()
        self._top.set((caller, *self._rest))
        try:
            return self._target.send(value)
        finally:
            self._top.set(caller)

    @hide
    def throw(self, *exception: Any) -> Any:
        return self._within(self._target.throw, *exception)

    @hide
    def close(self) -> None:
        self._within(self._target.close)

    @hide
    def _within(self, call: Callable[..., Any], *arguments: Any) -> Any:
        # `send` does the same by itself, for there is one at each step of a generator.
        caller = self._top.get()
        self._top.set((caller, *self._rest))
        try:
            return call(*arguments)
        finally:
            self._top.set(caller)
