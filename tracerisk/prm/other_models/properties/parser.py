"""Texts in PRISM's property language, read without recursion: no property holds another."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from tracerisk.errors import Location, ModelError
from tracerisk.prm.other_models.formats.prism.expressions import (
    Cursor,
    Expression,
    parse_expression,
)
from tracerisk.prm.other_models.formats.prism.tokens import Token, tokens_of
from tracerisk.prm.other_models.properties.property import (
    PATHS,
    Asked,
    Filter,
    Property,
    PropertyFile,
    Window,
)

_SIGNS = ("<", "<=", ">", ">=")
_FILTERS = ("avg", "first", "max", "min", "range", "state", "sum")
_TYPES = ("bool", "double", "int")
_OTHERS = {
    "Pmin": "choices of a controller (an mdp's Pmin and Pmax)",
    "Pmax": "choices of a controller (an mdp's Pmin and Pmax)",
    "Rmin": "choices of a controller (an mdp's Rmin and Rmax)",
    "Rmax": "choices of a controller (an mdp's Rmin and Rmax)",
    "A": "a property of all paths (A)",
    "E": "a property of some path (E)",
    "multi": "several objectives (multi)",
    "Pquant": "quantiles",
    "quantile": "quantiles",
}
_PATH_WORDS = (*PATHS, "R")


def parse_properties(text: str, file: str = "properties") -> PropertyFile:
    """Return the properties and declarations of a text.

    Raises ModelError with the position of what is malformed, or with the name of a construct
    that is not read: choices of a controller, properties in properties, LTL.
    """
    try:
        return _parsed(text, file)
    except RecursionError as error:
        raise ModelError("an expression nests too deeply", Location(file)) from error


def _parsed(text: str, file: str) -> PropertyFile:
    cursor = Cursor(tokens_of(text, file))
    lines = text.splitlines()
    property_file = PropertyFile(())
    properties: list[Property] = []
    while cursor.now.kind != "end":
        if cursor.accept(";"):
            continue
        if cursor.accept("const"):
            kind = cursor.take().text if cursor.now.text in _TYPES else ""
            name = cursor.name("the name of a constant")
            value = parse_expression(cursor) if cursor.accept("=") else None
            del kind  # every number is one
            _once(name, property_file.constants, "constant")
            property_file.constants[name.text] = value
            cursor.expect(";")
        elif cursor.now.text in ("formula", "label"):
            is_label = cursor.take().text == "label"
            known = property_file.labels if is_label else property_file.formulas
            if is_label and cursor.now.kind != "text":
                cursor.now.refuse("a label in quotes")
            name = cursor.take() if is_label else cursor.name("a name")
            cursor.expect("=")
            _once(name, known, "name")
            known[name.text.strip('"')] = parse_expression(cursor)
            cursor.expect(";")
        else:
            properties.append(_property(cursor, lines))
    return replace(property_file, properties=tuple(properties))


def _once(
    name: Token, known: dict[str, Expression] | dict[str, Expression | None], what: str
) -> None:
    if name.text.strip('"') in known:
        raise ModelError(f"duplicate {what} {name.text}; rename one", name.location)


def _property(cursor: Cursor, lines: list[str]) -> Property:
    name = ""
    if cursor.now.kind == "text":
        name = cursor.take().text.strip('"')
        cursor.expect(":")
    first = cursor.position
    chosen = None
    wrapped = cursor.accept("filter")
    if wrapped:
        cursor.expect("(")
        operator = cursor.name("the operator of a filter")
        if operator.text not in _FILTERS:
            raise ModelError(
                f"filter {operator.text} is not supported; allowed: {', '.join(_FILTERS)}",
                operator.location,
            )
        cursor.expect(",")
    question = _question(cursor)
    if wrapped:
        states = parse_expression(cursor) if cursor.accept(",") else None
        cursor.expect(")")
        chosen = Filter(operator.text, states)
    end = cursor.now
    if end.text == "{":
        raise ModelError("a filter in braces is not supported; write filter(...)", end.location)
    if end.kind == "sign" and end.text != ";":
        raise ModelError(
            f"'{end.text}' after a property: arithmetic and logic over properties are not "
            "supported",
            end.location,
        )
    text = _between(lines, cursor.tokens[first].location, cursor.tokens[cursor.position - 1])
    return replace(question, text=text, name=name, filter=chosen)


def _question(cursor: Cursor) -> Property:
    word = cursor.now
    if word.text in _OTHERS:
        raise ModelError(f"{_OTHERS[word.text]} is not supported; allowed: P, R, S", word.location)
    if word.text not in ("P", "R", "S"):
        word.refuse("a property that begins with P, R or S")
    cursor.take()
    reward: str | int | None = None
    if word.text == "R" and cursor.accept("{"):
        inside = cursor.take()
        if inside.kind == "number" and inside.text.isdigit():
            reward = int(inside.text[:9])
        elif inside.text.startswith('"'):
            reward = inside.text.strip('"')
        else:
            inside.refuse("the name of rewards in quotes")
        cursor.expect("}")
    if cursor.now.text in ("min", "max"):
        raise ModelError(f"{_OTHERS['Pmin']}: not supported", cursor.now.location)
    bound = None
    if cursor.accept("="):
        cursor.expect("?")
    elif cursor.now.text in _SIGNS:
        sign = cursor.take().text
        bound = sign, _number(cursor)
    else:
        cursor.now.refuse("=? or a limit such as >=0.99")
    cursor.expect("[")
    _check_flat(cursor)
    reads = {"P": _path, "R": _reward, "S": _long_run}
    asked = reads[word.text](cursor)
    cursor.expect("]")
    return Property("", "", word.location, word.text, asked, bound, reward)


def _check_flat(cursor: Cursor) -> None:
    """Raise ModelError for a property within this one, and for LTL."""
    depth, position = 1, cursor.position
    inside: list[Token] = []
    while depth and cursor.tokens[position].kind != "end":
        token = cursor.tokens[position]
        depth += {"[": 1, "]": -1}.get(token.text, 0)
        inside.append(token)
        position += 1
    words = 0
    for token, following in pairwise(inside):
        if token.kind != "name":
            continue
        operator = following.text in ("=", "{", *_SIGNS)
        if token.text in _OTHERS or (token.text in ("P", "R", "S") and operator):
            raise ModelError(
                f"{token.text} within a property: nested properties are not supported",
                token.location,
            )
        words += token.text in _PATH_WORDS
        if words > 1:
            raise ModelError(
                f"'{token.text}' beside another temporal operator: LTL is not supported; use one "
                "of F, G, U, W, X",
                token.location,
            )


def _path(cursor: Cursor) -> Asked:
    word = cursor.now
    if word.kind == "name" and word.text in ("F", "G", "X"):
        cursor.take()
        if word.text == "X":
            return Asked("X", parse_expression(cursor))
        window = _window(cursor)
        return Asked(word.text, parse_expression(cursor), None, window)
    left = parse_expression(cursor)
    word = cursor.now
    if word.text == "R":
        raise ModelError("the operator R (release) is not supported; use W", word.location)
    if word.kind != "name" or word.text not in ("U", "W"):
        word.refuse("F, G, U, W or X")
    cursor.take()
    window = _window(cursor)
    if word.text == "W" and window != Window():
        raise ModelError("W with a time bound is not supported", word.location)
    return Asked(word.text, parse_expression(cursor), left, window)


def _reward(cursor: Cursor) -> Asked:
    word = cursor.take()
    if word.text == "F":
        window = _window(cursor)
        if window != Window():
            raise ModelError("rewards until F with a time bound are not supported", word.location)
        return Asked("F", parse_expression(cursor))
    if word.text == "S":
        return Asked("S")
    if word.text == "C":
        if cursor.now.text == "]":
            return Asked("C")
        if not cursor.accept("<="):
            cursor.now.refuse("<= and a time")
        return Asked("C", window=Window(high=parse_expression(cursor)))
    if word.text in _PATH_WORDS:
        raise ModelError(
            f"rewards with {word.text} are not supported; allowed: F, C, I, S", word.location
        )
    if word.text != "I":
        word.refuse("F, C, I or S")
    cursor.expect("=")
    return Asked("I", window=Window(high=parse_expression(cursor)))


def _long_run(cursor: Cursor) -> Asked:
    return Asked("S", parse_expression(cursor))


def _window(cursor: Cursor) -> Window:
    if cursor.accept("["):
        low = parse_expression(cursor)
        cursor.expect(",")
        high = parse_expression(cursor)
        cursor.expect("]")
        return Window(low, high)
    sign = cursor.now.text
    if cursor.now.kind != "sign" or sign not in ("=", *_SIGNS):
        return Window()
    cursor.take()
    time = _number(cursor)
    if sign == "=":
        return Window(time, time)
    if sign[0] == "<":
        return Window(high=time, strict_high=sign == "<")
    return Window(low=time, strict_low=sign == ">")


def _number(cursor: Cursor) -> Expression:
    """Return a number, a name, or an expression in parentheses: what follows is the next part."""
    first = cursor.position
    if not cursor.accept("("):
        token = cursor.take()
        if token.kind not in ("number", "name"):
            token.refuse("a number, a name or an expression in parentheses")
        return parse_expression(Cursor([token, replace(cursor.now, kind="end", text="")]))
    depth = 1
    while depth:
        token = cursor.take()
        if token.kind == "end":
            token.refuse("')'")
        depth += {"(": 1, ")": -1}.get(token.text, 0)
    end = replace(cursor.now, kind="end", text="")
    inner = Cursor([*cursor.tokens[first : cursor.position], end])
    number = parse_expression(inner)
    if inner.now.kind != "end":
        inner.now.refuse("')'")
    return number


def _between(lines: list[str], start: Location, last: Token) -> str:
    """Return what stands from one word to another, on one line."""
    first, end = start.line or 1, last.location.line or 1
    columns = (start.column or 1) - 1, (last.location.column or 1) - 1 + len(last.text)
    kept = lines[first - 1 : end]
    kept[-1] = kept[-1][: columns[1]]
    kept[0] = kept[0][columns[0] :]
    return " ".join(" ".join(line.split("//")[0] for line in kept).split())
