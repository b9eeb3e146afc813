"""Convert a Python 2 source to the syntax of Python 3 in memory, each line in its place.

Only the syntax is converted here. What the same syntax means differently, `7 / 2` for instance, is
the matter of `instrument/python_2`. Two things go there in a form that Python 2 itself has not: a
parameter of a `def` that is a tuple is a name whose annotation is the tuple, and what an `except`
clause unpacks an exception into is the second argument of a call that names the exception.
"""

from __future__ import annotations

import io
import re
import sys
from collections import Counter
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

from tracerisk.common.dependencies import missing_extra
from tracerisk.instrument.source.python_2 import TUPLE_PARAMETER, UNPACKED, NotConvertibleError

try:
    import fissix  # noqa: F401 - it puts the loader of the grammar into its driver
    from fissix.pgen2 import driver, pgen, token, tokenize
    from fissix.pgen2.parse import ParseError
    from fissix.pgen2.tokenize import TokenError
except ImportError as error:
    raise missing_extra("python2", "reading a source of Python 2") from error


def _grammar(path: str, *_: object, **__: object) -> Any:
    # Its own loader writes into the user's cache, which a run may not.
    return pgen.generate_grammar(path)


driver.load_grammar = _grammar

from fissix.pygram import python_symbols as symbols  # noqa: E402 - it loads the grammar
from fissix.pytree import Leaf, Node  # noqa: E402
from fissix.refactor import RefactoringTool  # noqa: E402

_FIXERS = (*("except", "exec", "ne", "numliterals", "paren", "print", "raise", "repr", "throw"),)
_NEW_KEYWORDS = frozenset({"async", "await", "nonlocal"})
_FIRST_TAB = re.compile(r"^[ \f]*\t", re.MULTILINE)
_INDENT = re.compile(r"[ \t]*")
_TAB = 8  # the width that Python 2 gives to a tab


def converted(text: str) -> str:
    """Return a Python 2 source in the syntax of Python 3.

    Line ends become `\\n`, and tabs before code the spaces that Python 2 takes them for. Each line
    of the result stands for the same line of the source; comments, and the lines and indents at
    which functions and classes begin, are proved to be the same.

    Raises:
        NotConvertibleError: Python 2 cannot read it either, or a line would not keep its place.
    """
    result = _conversion(text)
    if isinstance(result, NotConvertibleError):
        raise NotConvertibleError(result.reason, result.line)
    return result


@lru_cache(maxsize=64)
def _conversion(text: str) -> str | NotConvertibleError:
    """Return the conversion or the refusal: an editor asks for both again and again."""
    tool = _tool()
    plain = text.replace("\r\n", "\n").replace("\r", "\n")
    plain = _without_tabs(plain if plain.endswith("\n") else plain + "\n")
    try:
        result = str(tool.refactor_string(plain, "source"))
        _check_places(plain, result)
    except NotConvertibleError as error:
        return error.with_traceback(None)
    except Exception as error:  # noqa: BLE001 - whatever fissix raises
        return NotConvertibleError(f"{type(error).__name__}: {error}")
    return result


@lru_cache(maxsize=1)
def _tool() -> RefactoringTool:
    """Return what converts, made once: it takes a third of a second."""

    class Tool(RefactoringTool):  # type: ignore[misc,unused-ignore]
        """Converts one source after the other."""

        def refactor_tree(self, tree: Any, name: str) -> bool:
            is_unicode = "unicode_literals" in tree.future_features
            for leaf in list(tree.leaves()):
                if leaf.type == token.NAME and leaf.value in _NEW_KEYWORDS:
                    leaf.value += "_"
                elif leaf.type == token.STRING:
                    leaf.value = _string(leaf.value, is_unicode=is_unicode)
            _name_tuples(tree)
            _name_tuples_of_lambdas(tree)
            _star_imports(tree)
            _name_unpacked(tree)
            return bool(super().refactor_tree(tree, name))

        def log_error(self, msg: str, *args: object, **_: object) -> None:
            error = sys.exc_info()[1]
            if isinstance(error, ParseError):
                raise NotConvertibleError(
                    f"Python 2 cannot read it either, near `{str(error.value).strip()}`",
                    error.context[1][0],
                )
            if isinstance(error, TokenError):
                raise NotConvertibleError(str(error.args[0]), error.args[1][0])
            if isinstance(error, SyntaxError):
                raise NotConvertibleError(str(error.msg), error.lineno)
            raise NotConvertibleError(msg % args)

    return Tool([f"fissix.fixes.fix_{name}" for name in _FIXERS])


def _string(literal: str, *, is_unicode: bool) -> str:
    """Return a string literal of Python 2 as Python 3 writes it."""
    quote = min(at for at in (literal.find("'"), literal.find('"')) if at >= 0)
    prefix, rest = literal[:quote].lower(), literal[quote:]
    if prefix == "ur":
        return f"r{rest}"
    if prefix or is_unicode:
        return literal
    # In a byte string these letters are no escapes.
    return re.sub(r"\\(.)", lambda m: f"\\{m[0]}" if m[1] in "NuU" else m[0], rest, flags=re.DOTALL)


def _name_tuples(tree: Any) -> None:
    """Make each parameter of a `def` that is a tuple a name, annotated with the tuple."""
    functions = [node for node in tree.pre_order() if node.type == symbols.funcdef]
    for number, node in enumerate(
        parameter
        for function in functions
        for parameter in function.children[2].pre_order()
        if parameter.type == symbols.tfpdef and parameter.children[0].type == token.LPAR
    ):
        pattern = str(node).strip()
        node.replace(Leaf(token.NAME, f"{TUPLE_PARAMETER}{number}: {pattern}", prefix=node.prefix))


def _name_tuples_of_lambdas(tree: Any) -> None:
    """Make each parameter of a lambda that is a tuple a name, which a comprehension unpacks."""
    kinds = (symbols.lambdef, symbols.old_lambdef)
    lambdas = [node for node in tree.pre_order() if node.type in kinds and len(node.children) == 4]
    for number, node in enumerate(reversed(lambdas)):
        parameters, body, unpacked = node.children[1], node.children[3], ""
        is_one = parameters.type == symbols.vfpdef
        for place, parameter in enumerate([parameters] if is_one else list(parameters.children)):
            if parameter.type == symbols.vfpdef and parameter.children[0].type == token.LPAR:
                name = f"{TUPLE_PARAMETER}{number}_{place}"
                unpacked += f" for {str(parameter).strip()} in [{name}]"
                parameter.replace(Leaf(token.NAME, name, prefix=parameter.prefix))
        if unpacked:
            begin, end = Leaf(token.NAME, "[(", prefix=body.prefix), f"){unpacked}][0]"
            inner = body.clone()
            inner.prefix = ""
            body.replace(Node(symbols.atom, [begin, inner, Leaf(token.NAME, end)]))


def _name_unpacked(tree: Any) -> None:
    """Make the target of an `except` clause a name, where it is a tuple or an attribute."""
    clauses = [node for node in tree.pre_order() if node.type == symbols.except_clause]
    for number, node in enumerate(clauses):
        if len(node.children) != 4 or node.children[3].type == token.NAME:
            continue
        kind, target = (str(child).strip() for child in (node.children[1], node.children[3]))
        text = f"{UNPACKED}({kind}, {target}) as {UNPACKED}{number}"
        for child in node.children[2:]:
            child.remove()
        node.children[1].replace(Leaf(token.NAME, text, prefix=" "))


def _star_imports(tree: Any) -> None:
    """Make an import of all names within a function one of the module, as no other is allowed."""
    for node in list(tree.pre_order()):
        if node.type != symbols.import_from or node.children[-1].type != token.STAR:
            continue
        module, above = str(node.children[1]).strip(), node.parent
        while above is not None and above.type != symbols.funcdef:
            above = above.parent
        if above is not None and not module.startswith("."):
            text = f'import {module}; exec("from {module} import *", globals())'
            node.replace(Leaf(token.NAME, text, prefix=node.prefix))


def _without_tabs(text: str) -> str:
    """Return a source with spaces for the tabs before code; lines within a string stay."""
    if _FIRST_TAB.search(text) is None:
        return text
    kept: set[int] = set()
    for token in _tokens(text):
        if "\n" in token[1] and token[1].strip():
            kept |= set(range(token[2][0] + 1, token[3][0] + 1))
    lines = text.split("\n")
    for number, line in enumerate(lines, 1):
        indent = _INDENT.match(line)
        if number not in kept and indent is not None and "\t" in indent[0]:
            lines[number - 1] = indent[0].expandtabs(_TAB) + line[indent.end() :]
    return "\n".join(lines)


def _check_places(before: str, after: str) -> None:
    """Raise NotConvertibleError unless both have the same lines, as far as it can be seen."""
    old, new = _marks(before), _marks(after)
    if old != new or before.count("\n") != after.count("\n"):
        line = min((mark[0] for mark in (old - new) + (new - old)), default=None)
        raise NotConvertibleError("its lines would not keep their places", line)


def _marks(text: str) -> Counter[tuple[int, int, str]]:
    """Return the comments, and what begins a function or a class, each with line and column.

    The column of a comment is 0: what stands before it may have become longer.
    """
    space = {token.INDENT, token.DEDENT, token.COMMENT}
    marks: Counter[tuple[int, int, str]] = Counter()
    is_begin = True
    for kind, value, (line, column), _, _ in _tokens(text):
        if value.startswith("#"):
            marks[line, 0, value.rstrip()] += 1
        elif value in ("def", "class") and is_begin:
            marks[line, column, value] += 1
        if kind in (token.NEWLINE, token.NL):
            is_begin = True
        elif kind not in space:
            is_begin = False
    return marks


def _tokens(text: str) -> Iterator[tuple[int, str, tuple[int, int], tuple[int, int], str]]:

    try:
        yield from tokenize.generate_tokens(io.StringIO(text).readline)
    except tokenize.TokenError as error:
        raise NotConvertibleError(str(error.args[0]), error.args[1][0]) from error
    except SyntaxError as error:
        raise NotConvertibleError(str(error.msg), error.lineno) from error
