"""Windows of a program, at which nobody sits: each of their buttons is pressed once.

A run has no screen. Of libraries for windows a program gets widgets that keep their values, call
what they are bound to and are never drawn. Its main loop presses the buttons in the order in which
they were made, those that end the program last, and returns: the window was closed.
"""

from __future__ import annotations

import inspect
import re
import runpy
import sysconfig
import threading
import traceback
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from math import degrees
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from tracerisk.ros.imports.placeholder_modules import (
    Placeholder,
    PlaceholderFinder,
    PlaceholderValues,
)

_STARRED: Mapping[str, str] = {
    "tkinter": (
        "BooleanVar Button Canvas Checkbutton DoubleVar Entry Frame IntVar Label LabelFrame "
        "Listbox Menu Menubutton Message OptionMenu PanedWindow PhotoImage Radiobutton Scale "
        "Scrollbar Spinbox StringVar TclError Text Tk Toplevel Variable Widget mainloop"
    ),
    "tkinter.ttk": (
        "Button Checkbutton Combobox Entry Frame Label LabelFrame Labelframe Menubutton Notebook "
        "PanedWindow Progressbar Radiobutton Scale Scrollbar Separator Sizegrip Spinbox Style "
        "Treeview Widget"
    ),
    "QtWidgets": (
        "QAction QApplication QButtonGroup QCheckBox QComboBox QDesktopWidget QDial QDialog "
        "QDoubleSpinBox QFileDialog QFormLayout QFrame QGridLayout QGroupBox QHBoxLayout "
        "QInputDialog QLCDNumber QLabel QLineEdit QListWidget QListWidgetItem QMainWindow QMenu "
        "QMenuBar QMessageBox QPlainTextEdit QProgressBar QPushButton QRadioButton QScrollArea "
        "QSizePolicy QSlider QSpacerItem QSpinBox QSplitter QStackedWidget QStatusBar QTabWidget "
        "QTableWidget QTableWidgetItem QTextBrowser QTextEdit QToolBar QToolButton QVBoxLayout "
        "QWidget"
    ),
    "QtCore": (
        "QCoreApplication QDateTime QEvent QMutex QObject QPoint QPointF QProcess QRect QRectF "
        "QRunnable QSettings QSize QThread QThreadPool QTime QTimer QUrl Qt Signal Slot pyqtSignal "
        "pyqtSlot"
    ),
    "QtGui": (
        "QBrush QCloseEvent QColor QCursor QFont QIcon QImage QKeyEvent QKeySequence QMovie "
        "QPainter QPalette QPen QPixmap QStandardItem QStandardItemModel QTextCursor"
    ),
}
"""What `import *` takes of a module, by the end of its name; of Qt what is most used."""

_BETWEEN_NS = 5_000_000_000
"""From one press to the next, in which most motions end [ns]; an own figure."""
_FIRST_NS = 1_000_000_000  # from the first look at the window to the first press
_LEAST_NS = 1_000_000  # of a timer
_A_TURN = 6.3  # a slider that goes further is not in radians
_ENDS = re.compile(r"(^|_|\b)(quit|exit|destroy|closing|shutdown|emergency)(_|\b|$)", re.IGNORECASE)
_PRESSED = frozenset({
    "activated", "clicked", "currentIndexChanged", "pressed", "released", "returnPressed",
    "sliderReleased", "toggled", "triggered", "valueChanged",
})  # fmt: skip
_KEY = re.compile(r"<?(?:KeyPress-|Key-)?(?P<key>[A-Za-z0-9]|Up|Down|Left|Right|Return|space)>?")


@dataclass(slots=True, eq=False)
class Windows:
    """The windows of one run, and what is bound to their widgets."""

    values: PlaceholderValues
    """What widgets give where numbers are asked of them, and the clock."""
    sleep_ns: Callable[[int], None]
    """The function that lets simulated time pass [ns]."""
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
    is_closed: bool = field(default=False, init=False)
    """Whether the program has closed its window."""
    _is_looping: bool = field(default=False, init=False)
    """Whether a main loop runs: a dialog within it is confirmed at once."""

    def bind(self, function: object, *given: object, text: object = "") -> None:
        """Press once, with as many of the values `given` as the function takes."""
        if callable(function) and not isinstance(function, Placeholder):
            name = getattr(function, "__name__", "")
            ends = _ENDS.search(name) or (isinstance(text, str) and _ENDS.search(text))
            (self._last if ends else self._buttons).append(lambda: _called(function, *given))

    def later(self, delay_ms: object, function: object, *given: object) -> None:
        """Call a function when the time has passed."""
        if callable(function) and not isinstance(function, Placeholder):
            delay_ns = max(_LEAST_NS, round(float(delay_ms) * 1e6))  # type: ignore[arg-type]
            due_ns = self.values.now_ns() + delay_ns
            self._timers.append((due_ns, lambda: _called(function, *given)))

    def every(self, interval_ms: object, functions: Sequence[Callable[..., Any]]) -> None:
        """Call functions again and again."""

        def tick() -> None:
            for function in functions:
                _called(function)
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
        calls = [call for _, call in sorted(due, key=lambda timer: timer[0])]
        left = self._buttons or self._last
        is_press = bool(left) and now_ns >= self._next_ns
        if is_press:
            calls.append(left.pop(0))
        for call in calls:
            try:
                call()
            except Exception:  # noqa: BLE001 - as the main loop of Tk, which goes on
                traceback.print_exc()
        if is_press:
            self._next_ns = self.values.now_ns() + _BETWEEN_NS

    def loop(self) -> int:
        """Press what is to be pressed, and return when the window is closed."""
        if self._is_looping:
            return 1
        self._is_looping = True
        try:
            while not self.is_closed:
                self.turn()
                assert self._next_ns is not None
                now_ns = self.values.now_ns()
                if now_ns >= self._next_ns and not (self._buttons or self._last):
                    break
                due_ns = min([self._next_ns, *(timer_ns for timer_ns, _ in self._timers)])
                self.sleep_ns(max(due_ns - now_ns, _LEAST_NS))
        finally:
            self._is_looping = False
        return 0


class Widget(Placeholder):
    """Whatever a program takes of a library for windows: a widget, a part of one, a function."""

    def __init__(self, name: str, windows: Windows, owner: Widget | None = None) -> None:
        super().__init__(name, windows.values)
        vars(self).update(_windows=windows, _owner=owner, _parts={}, _slots=[], _state={})

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
        if "command" in options:
            text = options.get("text", "")
            self._windows.bind(options["command"], self._value(), text=text)

    def _value(self) -> Any:
        """Return what the widget holds; a number where nobody put anything there."""
        state = self._state
        shown = state.get("textvariable", state.get("variable"))
        if isinstance(shown, Widget):
            return shown._value()
        if "value" not in state:
            low, high = state.get("from_"), state.get("to")
            state["value"] = self._windows.number(low, high)
        return state["value"]


def window_finder(names: Collection[str], windows: Windows) -> PlaceholderFinder:
    """Return the finder of libraries for windows, which goes before the real ones."""
    made = partial(widget_of, windows=windows)
    return PlaceholderFinder(names, made, _starred, is_first=True)


def _starred(module: str) -> Sequence[str]:
    parts = module.split(".")
    ends = (".".join(parts[-length:]) for length in (2, 1))
    named = next((_STARRED[end] for end in ends if end in _STARRED), "").split()
    return [*named, *_constants()] if parts[0] == "tkinter" else named


@lru_cache(maxsize=1)
def _constants() -> Mapping[str, object]:
    """Return the constants of Tk, as `END`; they are in a module that needs no screen."""
    file = Path(sysconfig.get_path("stdlib"), "tkinter", "constants.py")
    known = runpy.run_path(str(file)) if file.is_file() else {}
    return {name: value for name, value in known.items() if name.isupper()}


def widget_of(name: str, windows: Windows, owner: Widget | None = None) -> Any:
    """Return what a library for windows has under a name; an `except` clause needs a class."""
    module, _, constant = name.rpartition(".")
    if module in ("tkinter", "tkinter.constants") and constant in _constants():
        return _constants()[constant]
    last = name.rpartition(".")[2]
    if last[:1].isupper() and last.endswith(("Error", "Exception")):
        return type(last, (Exception,), {})
    return Widget(name, windows, owner)


def needs_screen(error: BaseException) -> bool:
    """Return whether an error says that Tk has no screen."""
    return type(error).__name__ == "TclError" and "display" in str(error)


def _called(function: Callable[..., Any], *given: object) -> Any:
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
    if name in _PRESSED:
        owner = signal._owner
        signal._windows.bind(slot, False if owner is None else owner._value())
    elif callable(slot):
        signal._slots.append(slot)


def _emit(signal: Any, *given: Any) -> None:
    for slot in signal._slots:
        _called(slot, *given)


def _start(widget: Any, interval_ms: Any = None, *_: Any) -> None:
    """Start a timer, or a thread of a library."""
    parts = widget._parts
    if "timeout" in parts:
        interval = widget._state.get("interval", 0) if interval_ms is None else interval_ms
        widget._windows.every(interval or 1, parts["timeout"]._slots)
    for slot in parts["started"]._slots if "started" in parts else ():
        _in_thread(slot)


def _configure(widget: Any, *given: Any, **named: Any) -> None:
    widget._note({**(given[0] if given and isinstance(given[0], dict) else {}), **named})


def _add_command(widget: Any, **named: Any) -> None:
    widget._windows.bind(named.get("command"), text=named.get("label", ""))


def _bind(widget: Any, sequence: Any = "", function: Any = None, *_: Any, **__: Any) -> None:
    """Bind an event: a press of a button or of a key that it names."""
    key = _KEY.fullmatch(str(sequence))
    if key is None and "Button" not in str(sequence):
        return
    pressed = key["key"] if key is not None else ""
    char = pressed if len(pressed) == 1 else ""
    event = SimpleNamespace(keysym=pressed, char=char, keycode=0, x=0, y=0, widget=widget)
    widget._windows.bind(function, event)


def _set(widget: Any, value: Any = "", *_: Any) -> None:
    widget._state["value"] = value


def _insert(widget: Any, _: Any = 0, value: Any = "", *__: Any) -> None:
    widget._state.setdefault("value", value)


def _set_range(widget: Any, low: Any = None, high: Any = None, *_: Any) -> None:
    widget._state.update({"from_": low, "to": high})


def _add_items(widget: Any, items: Any = (), *_: Any) -> None:
    first = items if isinstance(items, str) else next(iter(items), "")
    widget._state.setdefault("value", first)


def _close(widget: Any, *_: Any) -> None:
    widget._windows.is_closed = True


_METHODS: Mapping[str, Callable[..., Any]] = {
    **dict.fromkeys(("mainloop", "exec_", "exec"), lambda widget, *_: widget._windows.loop()),
    **dict.fromkeys(("update", "processEvents"), lambda widget, *_: widget._windows.turn()),
    **dict.fromkeys(("get", "value"), lambda widget, *_: widget._value()),
    **dict.fromkeys(("text", "toPlainText", "currentText"), lambda widget: str(widget._value())),
    **dict.fromkeys(("set", "setValue", "setText"), _set),
    **dict.fromkeys(("config", "configure"), _configure),
    **dict.fromkeys(("addItem", "addItems"), _add_items),
    **dict.fromkeys(("destroy", "quit"), _close),
    "after": lambda widget, delay=0, function=None, *given: widget._windows.later(
        delay, function, *given
    ),
    "singleShot": lambda widget, delay=0, function=None, *_: widget._windows.later(delay, function),
    "setInterval": lambda widget, interval=0: widget._state.update(interval=interval),
    "setRange": _set_range,
    "setMinimum": lambda widget, low: widget._state.update(from_=low),
    "setMaximum": lambda widget, high: widget._state.update(to=high),
    "add_command": _add_command,
    "bind": _bind,
    "connect": _connect,
    "emit": _emit,
    "insert": _insert,
    "protocol": lambda widget, _name="", function=None: None,  # noqa: ARG005
    "start": _start,
}
"""What the methods of widgets do whose names say it, in Tk and in Qt."""
