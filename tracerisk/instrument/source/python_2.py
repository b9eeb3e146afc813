"""What shows that a source that Python 3 can parse was written for Python 2; its own names."""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping, Sequence

RENAMED: Mapping[str, Sequence[str]] = {
    "BaseHTTPServer": ("http.server",),
    "ConfigParser": ("configparser",),
    "Cookie": ("http.cookies",),
    "Dialog": ("tkinter.dialog",),
    "HTMLParser": ("html.parser",),
    "Queue": ("queue",),
    "ScrolledText": ("tkinter.scrolledtext",),
    "SimpleHTTPServer": ("http.server",),
    "SimpleXMLRPCServer": ("xmlrpc.server",),
    "SocketServer": ("socketserver",),
    "StringIO": ("io",),
    "Tkinter": ("tkinter",),
    "UserDict": ("collections",),
    "__builtin__": ("builtins",),
    "anydbm": ("dbm",),
    "cPickle": ("pickle",),
    "cStringIO": ("io",),
    "commands": ("subprocess",),
    "cookielib": ("http.cookiejar",),
    "copy_reg": ("copyreg",),
    "dummy_thread": ("_thread",),
    "exceptions": ("builtins",),
    "httplib": ("http.client",),
    "md5": ("hashlib",),
    "sets": (),
    "sha": ("hashlib",),
    "thread": ("_thread",),
    "tkFileDialog": ("tkinter.filedialog",),
    "tkFont": ("tkinter.font",),
    "tkMessageBox": ("tkinter.messagebox",),
    "tkSimpleDialog": ("tkinter.simpledialog",),
    "ttk": ("tkinter.ttk",),
    "urllib2": ("urllib.request", "urllib.error"),
    "urlparse": ("urllib.parse",),
    "xmlrpclib": ("xmlrpc.client",),
}
"""The modules that have another name now, each with those that hold what it held."""
_OF_OTHERS = frozenset(
    {"Dialog", "ScrolledText", "SimpleXMLRPCServer", "tkFont", "tkSimpleDialog", "ttk"}
)
"""Those whose names modules of any other author may have as well."""
MODULES = frozenset(RENAMED) - _OF_OTHERS
"""Modules that only the library of Python 2 has."""
NAMES = frozenset(
    {"basestring", "execfile", "long", "raw_input", "reload", "unichr", "unicode", "xrange"}
)
"""Built-in functions and types that only Python 2 has."""
METHODS = frozenset({"has_key", "iteritems", "iterkeys", "itervalues"})
"""Methods of dictionaries that only Python 2 has."""
TUPLE_PARAMETER = "tracerisk_tuple_"
"""How the names of parameters begin that stand for a tuple of names."""
UNPACKED = "tracerisk_unpacked_"
"""The name of the call in an `except` clause, and how the name begins that it binds."""
_VERSIONS = frozenset(
    {"PY2", "PY3", "TYPE_CHECKING", "hexversion", "python_version", "version", "version_info"}
)
_INTERPRETER = re.compile(r"#!.*\bpython([23])")
_WORDS = re.compile(
    rf"^#!.*python2|\b({'|'.join(sorted(MODULES | NAMES | METHODS))})\b|\bprint\s*>>"
)


class NotConvertibleError(Exception):
    """A source that cannot be converted: the reason, and the line where one is known."""

    def __init__(self, reason: str, line: int | None = None) -> None:
        super().__init__(reason)
        self.reason = reason
        """What is wrong, in words that go behind "it cannot be converted in memory: "."""
        self.line = line
        """The line, from 1; `None` where none is known."""


def may_be_python_2(text: str) -> bool:
    """Return whether a source has any word that could be a sign: this is asked of each source."""
    return _WORDS.search(text) is not None


def shows_python_2(tree: ast.AST, text: str) -> bool:
    """Return whether a source uses something that Python 3 lacks.

    The interpreter that its first line names decides. A module imported where the failure is
    caught, or a name that the source gives itself, counts for nothing: such a source serves both.
    """
    interpreter = _INTERPRETER.match(text)
    if interpreter is not None:
        return interpreter[1] == "2"
    given = _given(tree)
    return any(
        _is_sign(node, given) for node, is_guarded in walk_with_guards(tree) if not is_guarded
    )


def is_only_python_3(tree: ast.AST) -> bool:
    """Return whether a tree has syntax that Python 2 has not, or imports ROS 2."""
    return any(map(_is_only_of_python_3, ast.walk(tree)))


def _is_only_of_python_3(node: ast.AST) -> bool:
    if isinstance(node, ast.arguments):
        given = [*node.posonlyargs, *node.args, *filter(None, (node.vararg, node.kwarg))]
        annotated = [
            arg for arg in given if arg.annotation and not isinstance(arg.annotation, ast.Tuple)
        ]
        return bool(node.posonlyargs or node.kwonlyargs or annotated)
    if isinstance(node, ast.FunctionDef):
        return node.returns is not None
    if isinstance(node, ast.ClassDef):
        return bool(node.keywords)
    if isinstance(node, ast.Raise):
        return node.cause is not None
    if isinstance(node, ast.Starred):
        return isinstance(node.ctx, ast.Store)
    if isinstance(node, ast.Call):
        return isinstance(node.func, ast.Name) and node.func.id == "super" and not node.args
    if isinstance(node, ast.Import):
        return any(alias.name.partition(".")[0] == "rclpy" for alias in node.names)
    if isinstance(node, ast.ImportFrom):
        return (node.module or "").partition(".")[0] == "rclpy"
    return isinstance(node, _ONLY_OF_PYTHON_3)


_ONLY_OF_PYTHON_3 = (
    *(ast.JoinedStr, ast.AnnAssign, ast.AsyncFunctionDef, ast.Await, ast.Nonlocal, ast.YieldFrom),
    *(ast.NamedExpr, ast.MatMult, ast.Match),
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
        if isinstance(node, ast.IfExp):
            is_asked = is_guarded or _asks_for_version(node.test)
            waiting += [(node.body, is_asked), (node.orelse, is_asked), (node.test, is_guarded)]
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


def _is_sign(node: ast.AST, given: set[str]) -> bool:
    if isinstance(node, ast.Import):
        return any(alias.name.partition(".")[0] in MODULES for alias in node.names)
    if isinstance(node, ast.ImportFrom):
        return not node.level and (node.module or "").partition(".")[0] in MODULES
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
        return node.id in NAMES and node.id not in given
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        name = node.func.attr
        # `six.iteritems(d)` serves both: the method itself takes nothing, or the key asked for.
        return name in METHODS - given and len(node.args) == (name == "has_key")
    # To Python 3 `print >>stream, x` shifts a function, which fails when it runs.
    return (
        isinstance(node, ast.BinOp)
        and isinstance(node.op, ast.RShift)
        and isinstance(node.left, ast.Name)
        and node.left.id == "print"
    )
