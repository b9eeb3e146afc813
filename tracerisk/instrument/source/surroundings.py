"""Where a source asks in what surroundings it runs: the environment, the date, the modules.

A run has its own of each. By what it reads there, a program may do something else on the robot.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from types import MappingProxyType

from tracerisk.instrument.source.dotted_names import dotted_name, last_name
from tracerisk.instrument.source.python_source import parsed

_ENVIRONMENT = frozenset({"environ", "environb", "getenv", "getenvb"})
_DATES = frozenset({"asctime", "ctime", "gmtime", "localtime", "strftime", "today", "utcnow"})
_CLOCKS = frozenset({"time.time", "time.time_ns", "time.clock_gettime", "time.clock_gettime_ns"})
_MODULES = frozenset({"sys.modules", "sys.meta_path", "sys.gettrace", "sys.getprofile"})
_OF_TWIN = ("tracerisk", "mujoco", "dm_control")


def asks_environment(node: ast.AST) -> bool:
    """Return whether a node of a source may read a variable of the environment."""
    return last_name(node) in _ENVIRONMENT


def asks_date(node: ast.AST) -> bool:
    """Return whether a node is a call that gives a date."""
    if not isinstance(node, ast.Call):
        return False
    name, of = last_name(node.func), getattr(node.func, "value", None)
    # Of a time that is given, these are no question.
    is_given = name != "today" and len(node.args) > (name == "strftime")
    return (name in _DATES and not is_given) or (name == "now" and "date" in last_name(of).lower())


def asks_clock(node: ast.AST) -> bool:
    """Return whether a node is a call that gives a date, or the time since one."""
    return asks_date(node) or (isinstance(node, ast.Call) and dotted_name(node.func) in _CLOCKS)


def asks_twin(node: ast.AST) -> bool:
    """Return whether by a node a run on the twin may be known from the robot, by what is loaded."""
    match node:
        case ast.Constant(value=str(text)):
            return any(name in text for name in _OF_TWIN) and "\n" not in text
        case ast.Import(names=names):
            return any(alias.name.startswith(_OF_TWIN) for alias in names)
        case ast.ImportFrom(module=str(module)):
            return module.startswith(_OF_TWIN)
    return dotted_name(node) in _MODULES


def places(sources: Mapping[str, bytes], is_met: Callable[[ast.AST], bool]) -> list[str]:
    """Return the lines of Python sources that have such a node, as `file:line`, sorted."""
    trees = {name: parsed(data) for name, data in sources.items() if name.endswith(".py")}
    return [
        f"{name}:{line}"
        for name, tree in sorted(trees.items())
        if tree is not None
        for line in sorted({getattr(node, "lineno", 0) for node in ast.walk(tree) if is_met(node)})
    ]


ASKED: Mapping[str, Callable[[ast.AST], bool]] = MappingProxyType(
    {
        "clock: the program asks for the date ({places}), and each run begins at "
        "2026-01-01T00:00:00 UTC: at another date it may do something else": asks_date,
        "program: it may ask whether it is simulated ({places}), by the modules that Python has "
        "loaded or by a name of the twin: on the robot it may do something else": asks_twin,
    }
)
"""What is reported of a program that asks so, with the lines in the place of `places`."""


def asked(sources: Mapping[str, bytes]) -> list[str]:
    """Return what Python sources ask of their surroundings that a run has other than the robot."""
    found = {words: places(sources, is_met) for words, is_met in ASKED.items()}
    return [words.format(places=", ".join(lines)) for words, lines in found.items() if lines]
