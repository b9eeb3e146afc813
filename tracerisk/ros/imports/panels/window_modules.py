"""Windows of a program, at which nobody sits: each of their buttons is pressed once.

A run has no screen. Of libraries for windows a program gets widgets that keep their values, call
what they are bound to and are never drawn. Its main loop presses the buttons in the order in which
they were made, those that end the program last, and returns: the window was closed.
"""

from __future__ import annotations

import inspect
import threading
import traceback
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from functools import partial
from math import degrees
from types import SimpleNamespace
from typing import Any

from tracerisk.ros.imports.panels import window_names as names
from tracerisk.ros.imports.placeholder_modules import (
    Placeholder,
    PlaceholderFinder,
    PlaceholderValues,
)

_BETWEEN_NS = 5_000_000_000
"""From one press to the next, in which most motions end [ns]; an own figure."""
_FIRST_NS = 1_000_000_000  # from the first look at the window to the first press
_LEAST_NS = 1_000_000  # of a timer
_A_TURN = 6.3  # a slider that goes further is not in radians


@dataclass(slots=True, eq=False)
class Windows:
    """The windows of one run, and what is bound to their widgets."""

    values: PlaceholderValues
    """What widgets give where numbers are asked of them, and the clock."""
    sleep_ns: Callable[[int], None]
    """The function that lets simulated time pass [ns]."""
    failed: Callable[[Exception], None]
    """The function that takes what a callback raised, with which the window goes on."""
    _buttons: list[Callable[[], Any]] = field(default_factory=list, init=False)
    """What is still to be pressed, in its order."""
    _last: list[Callable[[], Any]] = field(default_factory=list, init=False)
    """What is pressed when nothing else is left, because it ends the program."""
    _timers: list[tuple[int, Callable[[], Any]]] = field(default_factory=list, init=False)
    """What is due, each with its time [ns]."""
    _next_ns: int | None = field(default=None, init=False)
    """When the next button is pressed [ns]; `None` before the first loop."""
    _sliders: int = field(default=0, init=False)
    """The number of widgets that were asked for a number nobody gave them."""
    _is_closed: bool = field(default=False, init=False)
    """Whether the program has closed its window."""
    _is_looping: bool = field(default=False, init=False)
    """Whether a main loop runs: a dialog within it is confirmed at once."""
    _is_pressing: bool = field(default=False, init=False)
    """Whether what a button calls has not returned: nothing else is pressed meanwhile."""

    def bind(self, function: object, *given: object, text: object = "") -> None:
        """Press once, with as many of the values `given` as the function takes."""
        if callable(function) and not isinstance(function, Placeholder):
            name = getattr(function, "__name__", "")
            ends = names.ENDS.search(name) or (isinstance(text, str) and names.ENDS.search(text))
            (self._last if ends else self._buttons).append(lambda: called(function, *given))

    def later(self, delay_ms: object, function: object, *given: object) -> object:
        """Call a function when the time has passed, and return what `cancel` takes."""
        if not callable(function) or isinstance(function, Placeholder):
            return None
        delay_ns = 0 if isinstance(delay_ms, str) else round(float(delay_ms) * 1e6)  # type: ignore[arg-type]
        due_ns = self.values.now_ns() + max(_LEAST_NS, delay_ns)
        timer = due_ns, lambda: called(function, *given)
        self._timers.append(timer)
        return timer

    def cancel(self, timer: object) -> None:
        """Drop a timer: its function is not called any more."""
        self._timers = [waiting for waiting in self._timers if waiting is not timer]

    def every(self, interval_ms: object, function: Callable[[], bool]) -> None:
        """Call a function again and again, as long as it returns that it goes on."""

        def tick() -> None:
            if function():
                self.later(interval_ms, tick)

        self.later(interval_ms, tick)

    def number(self, least: object = None, most: object = None) -> float:
        """Return the number of a widget that nobody set: a joint of a posture, in its range."""
        posture = self.values.posture()
        value = posture[self._sliders % len(posture)]
        self._sliders += 1
        if isinstance(most, int | float) and isinstance(least, int | float):
            value = degrees(value) if max(abs(least), abs(most)) > _A_TURN else value
            value = min(max(value, least), most)
        return round(value, 3)

    def turn(self) -> None:
        """Do what is due at this instant: of timers, and the next press."""
        now_ns = self.values.now_ns()
        if self._next_ns is None:
            self._next_ns = now_ns + _FIRST_NS
        due = [timer for timer in self._timers if timer[0] <= now_ns]
        self._timers = [timer for timer in self._timers if timer[0] > now_ns]
        for _, call in sorted(due, key=lambda timer: timer[0]):
            self._call(call)
        left = self._buttons or self._last
        if left and now_ns >= self._next_ns and not self._is_pressing:
            self._is_pressing = True
            self._call(left.pop(0))
            self._is_pressing = False
            self._next_ns = self.values.now_ns() + _BETWEEN_NS

    def _call(self, function: Callable[[], Any]) -> None:
        try:
            function()
        except Exception as error:  # noqa: BLE001 - as the main loop of Tk, which goes on
            traceback.print_exc()
            self.failed(error)

    def close(self) -> None:
        """Close the window, and with it all that could still be pressed."""
        self._is_closed = True
        for waiting in (self._buttons, self._last, self._timers):
            waiting.clear()

    def loop(self) -> int:
        """Press what is to be pressed, and return when the window is closed.

        A callback that has closed the window may open another one, with its own loop.
        """
        if self._is_looping and not self._is_closed:
            return 1
        outer = self._is_looping, self._is_pressing
        self._is_closed, self._is_looping, self._is_pressing = False, True, False
        try:
            while not self._is_closed:
                self.turn()
                assert self._next_ns is not None
                now_ns = self.values.now_ns()
                if now_ns >= self._next_ns and not (self._buttons or self._last):
                    break
                due_ns = min([self._next_ns, *(timer_ns for timer_ns, _ in self._timers)])
                self.sleep_ns(max(due_ns - now_ns, _LEAST_NS))
        finally:
            self._is_closed = True
            self._is_looping, self._is_pressing = outer
        return 0


class Widget(Placeholder):
    """Whatever a program takes of a library for windows: a widget, a part of one, a function."""

    def __init__(self, name: str, windows: Windows, owner: Widget | None = None) -> None:
        super().__init__(name, windows.values)
        vars(self).update(
            _windows=windows, _owner=owner, _parts={}, _slots=[], _state={}, _bound=[]
        )

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        parts: dict[str, Any] = vars(self)["_parts"]
        if name not in parts:
            parts[name] = widget_of(f"{self._placeholder[0]}.{name}", self._windows, self)
        return parts[name]

    def __call__(self, *given: Any, **named: Any) -> Any:
        """Do what the name says; make a widget, or return what is decorated."""
        name = self._placeholder[0].rpartition(".")[2]
        windows: Windows = self._windows
        windows.values.count_call(self._placeholder[0])
        if name in _METHODS and self._owner is not None:
            return _METHODS[name](self._owner, *given, **named)
        if len(given) == 1 and not named and inspect.isfunction(given[0]):
            return given[0]
        made = Widget(f"{self._placeholder[0]}()", windows)
        made._note(named)
        return made

    def __mro_entries__(self, _: tuple[Any, ...]) -> tuple[type, ...]:
        """Return what a class of the program derives from instead of a widget."""
        name, windows = self._placeholder[0], self._windows

        class FromWidget:
            def __init__(self, *_: Any, **named: Any) -> None:
                self._widget._note(named)

            @property
            def _widget(self) -> Any:
                return vars(self).setdefault("_its_widget", Widget(f"{name}()", windows))

            def __getattr__(self, attribute: str) -> Any:
                if attribute.startswith("__"):
                    raise AttributeError(attribute)
                if attribute == "start" and "run" in dir(type(self)):
                    run: Callable[[], Any] = self.run
                    return lambda *_: _in_thread(run)
                return getattr(self._widget, attribute)

        return (FromWidget,)

    def __setitem__(self, key: Any, value: Any) -> None:
        """Set an option of the widget."""
        self._note({str(key): value})

    def _note(self, options: Mapping[str, Any]) -> None:
        """Take the options of a widget: what it calls, its range and what it shows."""
        self._state.update(options)
        values = options.get("values")
        if isinstance(values, list | tuple) and values:
            self._state.setdefault("value", values[0])
        if "command" in options and self._is_new(options["command"]):
            text = options.get("text", "")
            self._windows.bind(options["command"], self._value(), text=text)

    def _is_new(self, function: Any) -> bool:
        """Return whether a function is not bound to the widget yet, and note that it is now."""
        plain = getattr(function, "func", function)
        key = getattr(plain, "__code__", plain), getattr(plain, "__self__", None)
        is_new = not any(key[0] is code and key[1] is owner for code, owner in self._bound)
        self._bound.append(key)
        return is_new

    def _value(self) -> Any:
        """Return what the widget holds; a number where nobody put anything there."""
        state = self._state
        shown = state.get("textvariable", state.get("variable"))
        if isinstance(shown, Widget):
            return shown._value()
        if "value" not in state:
            is_whole = names.WHOLE.search(self._placeholder[0]) is not None
            low, high = state.get("from_", 0 if is_whole else None), state.get("to")
            number = self._windows.number(low, 99 if is_whole and high is None else high)
            state["value"] = round(number) if is_whole else number
        value = state["value"]
        return str(value) if names.TYPED.search(self._placeholder[0]) else value


def window_finder(modules: Collection[str], windows: Windows) -> PlaceholderFinder:
    """Return the finder of libraries for windows, which goes before the real ones."""
    made = partial(widget_of, windows=windows)
    return PlaceholderFinder(modules, made, names.starred, is_first=True)


def widget_of(name: str, windows: Windows, owner: Widget | None = None) -> Any:
    """Return what a library for windows has under a name; an `except` clause needs a class."""
    module, _, constant = name.rpartition(".")
    if module in ("tkinter", "tkinter.constants") and constant in names.tk_constants():
        return names.tk_constants()[constant]
    last = name.rpartition(".")[2]
    if last[:1].isupper() and last.endswith(("Error", "Exception")):
        return type(last, (Exception,), {})
    return Widget(name, windows, owner)


def called(function: Callable[..., Any], *given: object) -> Any:
    """Call a function with as many of the values as it takes."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return function()
    if any(parameter.kind is parameter.VAR_POSITIONAL for parameter in parameters):
        return function(*given)
    places = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    taken = [
        parameter
        for parameter in parameters
        if parameter.kind in places and parameter.default is parameter.empty
    ]
    return function(*given[: len(taken)])


def _in_thread(function: Callable[[], Any]) -> None:
    threading.Thread(target=function, daemon=True).start()


def _connect(signal: Any, slot: Any = None, *_: Any, **__: Any) -> None:
    name = signal._placeholder[0].rpartition(".")[2]
    if name in names.PRESSED:
        if not signal._is_new(slot):
            return
        owner = signal._owner
        signal._windows.bind(slot, False if owner is None else owner._value())
    elif callable(slot):
        signal._slots.append(slot)


def _emit(signal: Any, *given: Any) -> None:
    for slot in signal._slots:
        called(slot, *given)


def _start(widget: Any, interval_ms: Any = None, *_: Any) -> None:
    """Start a timer, or a thread of a library."""
    parts, state = widget._parts, widget._state
    if "timeout" in parts:
        started = state["started"] = object()

        def tick() -> bool:
            if state.get("started") is started:
                _emit(parts["timeout"])
            return state.get("started") is started and not state.get("is_single")

        interval = state.get("interval", 0) if interval_ms is None else interval_ms
        widget._windows.every(interval or 1, tick)
    for slot in parts["started"]._slots if "started" in parts else ():
        _in_thread(slot)


def _configure(widget: Any, *given: Any, **named: Any) -> None:
    widget._note({**(given[0] if given and isinstance(given[0], dict) else {}), **named})


def _add_command(widget: Any, **named: Any) -> None:
    widget._windows.bind(named.get("command"), text=named.get("label", ""))


def _bind(widget: Any, sequence: Any = "", function: Any = None, *_: Any, **__: Any) -> None:
    """Bind an event: a press of a button or of a key that it names."""
    key = names.KEY.fullmatch(str(sequence))
    if key is None and "Button" not in str(sequence):
        return
    pressed = key["key"] if key is not None else ""
    char = pressed if len(pressed) == 1 else ""
    event = SimpleNamespace(keysym=pressed, char=char, keycode=0, x=0, y=0, widget=widget)
    widget._windows.bind(function, event)


def _after(widget: Any, ms: Any = 0, func: Any = None, *given: Any) -> Any:
    """Call a function later; without one, wait."""
    if func is None and not isinstance(ms, str):
        return widget._windows.sleep_ns(max(0, round(float(ms) * 1e6)))
    return widget._windows.later(ms, func, *given)


def _set(widget: Any, value: Any = "", *_: Any, **__: Any) -> None:
    widget._state["value"] = value


def _insert(widget: Any, _: Any = 0, value: Any = "", *__: Any, **___: Any) -> None:
    widget._state.setdefault("value", value)


def _set_range(widget: Any, low: Any = None, high: Any = None, *_: Any) -> None:
    widget._state.update({"from_": low, "to": high})


def _add_items(widget: Any, items: Any = (), *_: Any) -> None:
    first = items if isinstance(items, str) else next(iter(items), "")
    widget._state.setdefault("value", first)


def _close(widget: Any, *_: Any) -> None:
    """Close the window of the program; a widget in it, or a dialog, leaves it open."""
    if names.PROGRAM.search(widget._placeholder[0]):
        widget._windows.close()


def _quit(widget: Any, *_: Any) -> None:
    """End the main loop, which each widget of Tk can; of Qt, a thread has such a method, too."""
    if names.PROGRAM.search(name := widget._placeholder[0]) or not names.OF_QT.search(name):
        widget._windows.close()


_METHODS: Mapping[str, Callable[..., Any]] = {
    **dict.fromkeys(("mainloop", "exec_", "exec"), lambda widget, *_: widget._windows.loop()),
    **dict.fromkeys(("update", "processEvents"), lambda widget, *_: widget._windows.turn()),
    **dict.fromkeys(("get", "value"), lambda widget, *_: widget._value()),
    **dict.fromkeys(
        ("text", "toPlainText", "currentText"), lambda widget, *_: str(widget._value())
    ),
    **dict.fromkeys(("set", "setValue", "setText"), _set),
    **dict.fromkeys(("config", "configure"), _configure),
    **dict.fromkeys(("addItem", "addItems"), _add_items),
    "after": _after,
    "after_cancel": lambda widget, timer=None: widget._windows.cancel(timer),
    "after_idle": lambda widget, func=None, *given: widget._windows.later(0, func, *given),
    "destroy": _close,
    "quit": _quit,
    "singleShot": lambda widget, delay=0, function=None, *_: widget._windows.later(delay, function),
    "setSingleShot": lambda widget, is_single=True: widget._state.update(is_single=is_single),
    "stop": lambda widget, *_: widget._state.pop("started", None) and None,
    "setInterval": lambda widget, interval=0: widget._state.update(interval=interval),
    "setRange": _set_range,
    "setMinimum": lambda widget, low: widget._state.update(from_=low),
    "setMaximum": lambda widget, high: widget._state.update(to=high),
    "add_command": _add_command,
    "bind": _bind,
    "connect": _connect,
    "emit": _emit,
    "insert": _insert,
    **dict.fromkeys(("winfo_children", "get_children"), lambda *_: []),
    "start": _start,
}
"""What the methods of widgets do whose names say it, in Tk and in Qt."""
