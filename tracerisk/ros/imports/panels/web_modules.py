"""Web servers of a program, which no browser asks: each of their routes is requested once.

A run has no network. Of libraries for web servers a program gets an app that keeps what answers
its routes. Where it serves, it requests each route in the order in which they were made, and
returns: the server was stopped. What a request holds is a placeholder, whose numbers are a posture
of the arm.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Collection
from functools import partial, wraps
from typing import Any

from tracerisk.ros.imports.panels.window_modules import Windows
from tracerisk.ros.imports.placeholder_modules import Placeholder, PlaceholderFinder

_APP = re.compile(r"\.(APIRouter|Blueprint|FastAPI|Flask|Quart|Sanic|SocketIO)\(\)$")
"""What has routes, by the name of its class."""
_ROUTES = frozenset({
    "api_route", "delete", "event", "get", "on", "patch", "post", "put", "route", "websocket",
})  # fmt: skip
"""Methods of such an app that take what answers a route, most as decorators."""
_SERVES = re.compile(r"(\)|uvicorn|hypercorn|waitress)\.(run|serve)$")
"""What serves until the server is stopped."""
_MOST_GIVEN = 8
"""As many parts of a route as what answers it may take; an own figure."""


class WebPart(Placeholder):
    """Whatever a program takes of a library for web servers: an app, a request, an answer."""

    def __init__(self, name: str, windows: Windows, owner: WebPart | None = None) -> None:
        super().__init__(name, windows.values)
        vars(self).update(_windows=windows, _owner=owner)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return _part_of(f"{self._placeholder[0]}.{name}", self._windows, self)

    def __getitem__(self, key: Any) -> Any:
        """Return a field of what was sent, by its name, or a number of it."""
        if isinstance(key, str):
            return WebPart(f"{self._placeholder[0]}[]", self._windows)
        return super().__getitem__(key)

    def __call__(self, *given: Any, **named: Any) -> Any:
        """Do what the name says: take what answers a route, serve, or return another part."""
        name, owner = self._placeholder[0], self._owner
        last = name.rpartition(".")[2]
        self._windows.values.count_call(name)
        if owner is not None and last in _ROUTES and _APP.search(owner._placeholder[0]):
            functions = [function for function in given if inspect.isroutine(function)]
            return self._answered(functions[0]) if functions else self._answered
        if _SERVES.search(name):
            return self._windows.loop()
        default = given[1] if last == "get" and len(given) > 1 else None
        if isinstance(default, int | float | str) and default:
            return default  # a client that leaves out what it may leave out
        if len(given) == 1 and not named and inspect.isroutine(given[0]):
            return given[0]
        return WebPart(f"{name}()", self._windows)

    def _answered(self, answer: Callable[..., Any]) -> Callable[..., Any]:
        """Request a route once, and return what answers it."""

        @wraps(answer)
        def request(*parts: Any) -> None:
            result = answer(*parts)
            if inspect.iscoroutine(result):
                import asyncio  # no run needs it that has no such route

                asyncio.run(result)

        sent = WebPart("request.sent", self._windows)
        self._windows.bind(request, *[sent] * _MOST_GIVEN)
        return answer

    def __eq__(self, other: object) -> bool:
        """Return whether a request is of a method that is asked for: one that sends something."""
        return super().__eq__(other) or (
            self._placeholder[0].endswith("request.method") and other in ("POST", "PUT")
        )

    __hash__ = Placeholder.__hash__


def web_finder(modules: Collection[str], windows: Windows) -> PlaceholderFinder:
    """Return the finder of libraries for web servers, which goes before the real ones."""
    return PlaceholderFinder(modules, partial(_part_of, windows=windows), is_first=True)


def _part_of(name: str, windows: Windows, owner: WebPart | None = None) -> Any:
    """Return what a library has under a name; an `except` clause needs a class."""
    last = name.rpartition(".")[2]
    if last[:1].isupper() and last.endswith(("Error", "Exception", "Disconnect")):
        return type(last, (Exception,), {})
    return WebPart(name, windows, owner)
