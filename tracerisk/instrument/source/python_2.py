"""What shows that a source that Python 3 can parse was written for Python 2."""

from __future__ import annotations

import ast

from tracerisk.instrument.source.python_source import parsed

MODULES = frozenset(
    {
        *("BaseHTTPServer", "ConfigParser", "Cookie", "HTMLParser", "Queue", "SimpleHTTPServer"),
        *("SocketServer", "StringIO", "Tkinter", "UserDict", "__builtin__", "anydbm", "cPickle"),
        *("cStringIO", "commands", "cookielib", "copy_reg", "dummy_thread", "exceptions"),
        *("httplib", "md5", "sets", "sha", "thread", "tkFileDialog", "tkMessageBox", "urllib2"),
        *("urlparse", "xmlrpclib"),
    }
)
"""Modules that only the library of Python 2 has."""
NAMES = frozenset(
    {"basestring", "execfile", "long", "raw_input", "reload", "unichr", "unicode", "xrange"}
)
"""Built-in functions and types that only Python 2 has."""
METHODS = frozenset({"has_key", "iteritems", "iterkeys", "itervalues"})
"""Methods of dictionaries that only Python 2 has."""
_VERSIONS = frozenset({"PY2", "PY3", "TYPE_CHECKING", "python_version", "version", "version_info"})
_MOST = 4


def python_2_hint(source: bytes, file: str) -> str | None:
    """Return one hint for all that Python 3 lacks of what a source uses, `None` for nothing.

    A module imported where the failure is caught, or a name that the source gives itself, counts
    for nothing: such a source serves both.
    """
    tree = parsed(source)
    if tree is None:
        return None
    given = _given(tree)
    numbers: dict[str, int] = {}
    for node, is_guarded in walk_with_guards(tree):
        for sign in () if is_guarded else _signs(node, given):
            numbers.setdefault(sign, getattr(node, "lineno", 1))
    if not numbers:
        return None
    shown = sorted(numbers, key=lambda sign: (numbers[sign], sign))
    text = ", ".join(f"`{sign}` (line {numbers[sign]})" for sign in shown[:_MOST])
    more = f" and {len(shown) - _MOST} more" if len(shown) > _MOST else ""
    return (
        f"{file} is Python 2: {text}{more}; convert it first, e.g. with `2to3 -w {file}` or "
        f"`python-modernize -w {file}`"
    )


def walk_with_guards(tree: ast.AST) -> list[tuple[ast.AST, bool]]:
    """Return the nodes of a tree, and whether what fails there is expected to."""
    pairs: list[tuple[ast.AST, bool]] = []
    waiting: list[tuple[ast.AST, bool]] = [(tree, False)]
    while waiting:
        node, is_guarded = waiting.pop()
        pairs.append((node, is_guarded))
        if isinstance(node, ast.Try):
            is_tried = is_guarded or any(map(_catches, node.handlers))
            waiting += [(child, is_tried) for child in node.body]
            others = (*node.orelse, *node.finalbody)
            waiting += [(child, is_guarded) for child in others]
            # A handler is the alternative for Python 3, so it is guarded too.
            waiting += [(child, is_tried) for child in node.handlers]
            continue
        if isinstance(node, ast.If):
            is_asked = is_guarded or _asks_for_version(node.test)
            waiting += [(child, is_asked) for child in (*node.body, *node.orelse)]
            waiting.append((node.test, is_guarded))
            continue
        waiting += [(child, is_guarded) for child in ast.iter_child_nodes(node)]
    return pairs


def _catches(handler: ast.ExceptHandler) -> bool:
    kinds = {"ImportError", "ModuleNotFoundError", "NameError", "AttributeError", "Exception"}
    return handler.type is None or any(
        isinstance(node, ast.Name) and node.id in {*kinds, "BaseException"}
        for node in ast.walk(handler.type)
    )


def _asks_for_version(test: ast.expr) -> bool:
    words = {getattr(node, "attr", getattr(node, "id", "")) for node in ast.walk(test)}
    return bool(words & _VERSIONS)


def _given(tree: ast.AST) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        elif isinstance(node, ast.alias):
            names.add((node.asname or node.name).partition(".")[0])
        elif isinstance(node, ast.arg):
            names.add(node.arg)
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
    return names


def _signs(node: ast.AST, given: set[str]) -> list[str]:
    if isinstance(node, ast.Import):
        return [f"import {a.name}" for a in node.names if a.name.partition(".")[0] in MODULES]
    if isinstance(node, ast.ImportFrom):
        top = (node.module or "").partition(".")[0]
        return [f"import {top}"] if not node.level and top in MODULES else []
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
        return [node.id] if node.id in NAMES and node.id not in given else []
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        return [f".{node.func.attr}()"] if node.func.attr in METHODS else []
    return []
