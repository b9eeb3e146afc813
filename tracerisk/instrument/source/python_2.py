"""What shows that a source that Python 3 can parse was written for Python 2; its own names."""

from __future__ import annotations

import ast
import builtins
import io
import re
import tokenize
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

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
_BARE_CLAUSE = re.compile(r"^\s*except\b[^:#\n]*,", re.MULTILINE)
_EXCEPTIONS = frozenset(
    name
    for name, value in vars(builtins).items()
    if isinstance(value, type) and issubclass(value, BaseException)
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


class BareClause(NamedTuple):
    """An `except` clause with a comma and no parentheses: `except ValueError, name:`.

    Python 2 gives the exception the name; Python 3.14 catches either of two.
    """

    begin: tuple[int, int]
    """Where the first exception begins: its line, from 1, and its column, from 0."""
    end: tuple[int, int]
    """Where the last name ends."""
    last: str | None
    """The one name behind the one comma; `None` where Python 2 cannot read the clause."""


def bare_clauses(text: str) -> list[BareClause]:
    """Return the `except` clauses of a source that have a comma outside of parentheses."""
    if not _BARE_CLAUSE.search(text):
        return []
    try:
        return list(_clauses(tokenize.generate_tokens(io.StringIO(text).readline)))
    except (tokenize.TokenError, SyntaxError):
        return []


def _clauses(tokens: Iterator[tokenize.TokenInfo]) -> Iterator[BareClause]:
    is_first = True
    for token in tokens:
        if is_first and token.string == "except":
            parts: list[tokenize.TokenInfo] = []
            commas: list[int] = []
            depth = 0
            for part in tokens:
                depth += (part.string in {"(", "[", "{"}) - (part.string in {")", "]", "}"})
                if part.type == tokenize.NEWLINE or (part.string == ":" and depth == 0):
                    break
                if part.string == "," and depth == 0:
                    commas.append(len(parts))
                if part.type not in {tokenize.NL, tokenize.COMMENT}:
                    parts.append(part)
            if commas and 0 < commas[-1] < len(parts) - 1:
                is_one = commas == [len(parts) - 2] and parts[-1].type == tokenize.NAME
                is_star = parts[0].string == "*"
                last = parts[-1].string if is_one and not is_star else None
                yield BareClause(parts[is_star].start, parts[-1].end, last)
        is_first = token.type in {tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT} or (
            is_first and token.type in {tokenize.NL, tokenize.COMMENT, tokenize.ENCODING}
        )


def is_caught(clause: BareClause, tree: ast.AST | None) -> bool:
    """Return whether the last name of a clause is that of an exception, so that both are caught.

    So it is if it is built in, if the source imports it or defines a class of that name, or if it
    begins with a capital and the source gives it some value or imports all of a module. Where
    there is no tree, a capital is enough.
    """
    name = clause.last
    if name is None or name in _EXCEPTIONS:
        return True
    is_capital = name.lstrip("_")[:1].isupper()
    if tree is None:
        return is_capital
    imported = {
        (alias.asname or alias.name).partition(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    }
    classes = {node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef)}
    return name in imported | classes or (
        is_capital and bool({name, "*"} & (imported | _given(tree)))
    )


def binds_in_bare_clauses(text: str, tree: ast.AST) -> bool:
    """Return whether a source that Python 3.14 can parse names an exception as Python 2 does."""
    if _INTERPRETER.match(text):
        return False
    return not all(is_caught(clause, tree) for clause in bare_clauses(text))


def catches_in_bare_clauses(text: str) -> bool:
    """Return whether nothing but clauses as of Python 3.14 keeps an older Python from a source."""
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    clauses = bare_clauses(text)
    lines = text.split("\n")
    for clause in reversed(clauses):
        for (line, column), sign in ((clause.end, ")"), (clause.begin, "(")):
            lines[line - 1] = f"{lines[line - 1][:column]}{sign}{lines[line - 1][column:]}"
    try:
        tree = ast.parse("\n".join(lines))
    except (SyntaxError, ValueError, RecursionError):
        return False
    if may_be_python_2(text) and shows_python_2(tree, text):
        return False
    if (interpreter := _INTERPRETER.match(text)) is not None:
        return interpreter[1] == "3"
    return bool(clauses) and all(is_caught(clause, tree) for clause in clauses)


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
