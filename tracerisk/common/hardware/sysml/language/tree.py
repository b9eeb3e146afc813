"""Build the syntax tree of a SysML v2 file while lark parses it."""
# ruff: noqa: D102 - each method is named after the rule of grammar.lark that it serves

from __future__ import annotations

import re
from collections.abc import Sequence as Several
from dataclasses import replace
from typing import Any, TypeAlias

from lark import Token, Transformer, v_args

from tracerisk.common.hardware.sysml.language import syntax
from tracerisk.common.hardware.sysml.language.syntax import (
    Alias,
    Annotation,
    Computed,
    Element,
    Expression,
    Import,
    Instance,
    Literal,
    Member,
    Multiplicity,
    Operation,
    Package,
    Quantity,
    Reference,
    Sequence,
    Skipped,
    Unary,
    Value,
)
from tracerisk.common.hardware.sysml.language.words import WORDS
from tracerisk.errors import HardwareError

_ESCAPE = re.compile(r"\\([\s\S])")
_ESCAPES = {"n": "\n", "t": "\t", "r": "\r", "b": "\b", "f": "\f"}
_METADATA_NAME = r"(?:'(?:[^'\\\n]|\\.)*'|[^\W\d]\w*)"
_SKIPPED_METADATA = re.compile(
    rf"(?:[@#]|\bmetadata\b)\s*(?:{_METADATA_NAME}\s*:\s*(?!:))?"
    rf"({_METADATA_NAME}(?:\s*::\s*{_METADATA_NAME})*)"
)
_SKIPPED_NAME = re.compile(rf"{_METADATA_NAME}|([^\s<>])")
_MAX_SEGMENTS = 100
_WORDS = {"subsets": ":>", "specializes": ":>", "redefines": ":>>"}

Feature: TypeAlias = tuple[str, Any]
"""A part of a declaration: the sign of its kind, and what it holds."""
Ident: TypeAlias = tuple[str | None, str | None, int]
"""Name, short name, and where the first of them stands."""


def unquoted(token: str) -> str:
    """Return a name or a text without its quotes, escapes resolved."""
    if token[0] not in "'\"":
        return str(token)
    inner = token[1:-1]
    if "\\" not in inner:
        return inner
    return _ESCAPE.sub(lambda found: _ESCAPES.get(found.group(1), found.group(1)), inner)


def _at(token: Token) -> int:
    assert token.start_pos is not None
    return token.start_pos


class NotationError(Exception):
    """Something that the notation allows but that has no meaning; becomes a HardwareError."""

    def __init__(self, message: str, at: int) -> None:
        super().__init__(message)
        self.message = message
        self.at = at


@v_args(inline=True)
class TreeBuilder(Transformer[Token, Package]):
    """Each method takes what a rule of the grammar has found, and returns a node of the tree."""

    # The top, and bodies.

    def start(self, *members: Member | None) -> Package:
        return Package(None, None, tuple(member for member in members if member is not None), 0)

    def body(self, *members: Member | None) -> tuple[Member, ...]:
        return tuple([member for member in members if member is not None])

    def empty_body(self) -> tuple[Member, ...]:
        return ()

    def note(self, *parts: object) -> None:
        del parts

    locale = filter = note

    def skipped(self, token: Token) -> Skipped:
        word = re.split(r"[^a-z]", str(token), maxsplit=1)[0]
        named = []
        if "@" in token or "#" in token or "metadata" in token:
            for match_ in _SKIPPED_METADATA.finditer(str(token)):
                segments = re.findall(_METADATA_NAME, match_.group(1))
                at = _at(token) + match_.start(1)
                named.append(Reference(tuple(map(unquoted, segments)), at))
        return Skipped(word, _declared(str(token)), tuple(named), _at(token))

    # Names.

    def name(self, token: Token) -> Reference:
        return Reference((unquoted(token),), _at(token))

    def longer_name(self, name: Reference, token: Token) -> Reference:
        _check_length(name)
        return Reference((*name.name, unquoted(token)), name.at)

    def longer_reference(self, first: Reference, then: Reference) -> Reference:
        _check_length(first)
        return Reference(first.name, first.at, (*first.steps, then.name))

    def plain_ident(self, token: Token) -> Ident:
        return unquoted(token), None, _at(token)

    def short_ident(
        self, less: Token, short: Token, greater: Token, name: Token | None = None
    ) -> Ident:
        del less, greater
        at = _at(short if name is None else name)
        return None if name is None else unquoted(name), unquoted(short), at

    # Packages.

    def package(self, *parts: Any) -> Package:
        name, short, at = parts[0] if len(parts) == 2 else (None, None, 0)
        return Package(name, short, parts[-1], at)

    def import_target(self, name: Reference, *stars: Token) -> tuple[Reference, bool, bool]:
        return name, any(star == "*" for star in stars), any(star == "**" for star in stars)

    def imported(self, *parts: Any) -> Import:
        is_all = isinstance(parts[0], Token)
        target, every, recursive = parts[1] if is_all else parts[0]
        return Import(target, every, recursive, False, target.at, overrides_private=is_all)

    def alias(self, *parts: Any) -> Alias:
        name, short, at = parts[0] if len(parts) == 3 else (None, None, parts[0].at)
        return Alias(name, short, parts[-2], at)

    # Definitions and usages.

    def prefix(self, token: Token) -> Token:
        return token

    def prefix_metadata(self, name: Reference) -> Annotation:
        return Annotation(name, None, (), (), name.at)

    def prefixed(self, *parts: Any) -> Member | None:
        core = parts[-1]
        words = [part for part in parts[:-1] if isinstance(part, Token)]
        if isinstance(core, Import):
            return replace(core, is_private="private" in words)
        if not isinstance(core, Element):
            return core  # type: ignore[no-any-return]
        marks = tuple(part for part in parts[:-1] if isinstance(part, Annotation))
        return replace(core, prefixes=tuple(map(str, words)), annotations=marks)

    def definition(self, kind: Token, *parts: Any) -> Element:
        return _element(str(kind), True, _at(kind), parts)

    def wordless_definition(self, *parts: Any) -> Element:
        return _element("part", True, 0, parts)

    def metadata_definition(self, *parts: Any) -> Element:
        return _element("metadata", True, 0, parts)

    def usage(self, kind: Token, *parts: Any) -> Element:
        return _element(str(kind), False, _at(kind), parts)

    def bare(self, *parts: Any) -> Element:
        return _element("", False, 0, parts)

    def metadata(self, *parts: Any) -> Annotation:
        rest = [part for part in parts if part is not None and not isinstance(part, Token)]
        members = rest.pop()
        about = rest.pop() if isinstance(rest[-1], tuple) and len(rest) > 1 else ()
        kind = rest.pop()
        name, _, at = rest[0] if rest else (None, None, kind.at)
        return Annotation(kind, name, about, members, at)

    def about(self, *targets: Reference) -> tuple[Reference, ...]:
        return targets

    # What follows a declared name.

    def conjugated(self, sign: Token, reference: Reference) -> Reference:
        del sign
        return reference

    def typing(self, *types: Reference) -> Feature:
        return ":", types

    def relation(self, sign: Token, *targets: Reference) -> Feature:
        return _WORDS.get(str(sign), str(sign)), targets

    def flag(self, token: Token) -> Feature:
        return str(token), ()

    def multiplicity(self, bracket: Token, *bounds: Any) -> Feature:
        first, last = bounds[0], bounds[-1]
        if len(bounds) == 1:
            lower = 0 if str(first) == "*" else _bound(first)
        else:
            lower = _bound(first)
            last = bounds[2]
        upper = None if not isinstance(last, Reference) and last == "*" else _bound(last)
        return "[", Multiplicity(lower, upper, _at(bracket))

    def value(self, expression: Expression) -> Value:
        return Value(expression, is_default=False)

    def default_value(self, expression: Expression) -> Value:
        return Value(expression, is_default=True)

    # Expressions.

    def number(self, token: Token) -> Literal:
        text = str(token)
        at = _at(token)
        if text.isdigit():
            if len(text) > 300:
                raise NotationError("a number of more than 300 digits; write it as 1e300", at)
            return Literal(int(text), at)
        return Literal(float(text), at)

    def string(self, token: Token) -> Literal:
        return Literal(unquoted(token), _at(token))

    def boolean(self, token: Token) -> Literal:
        return Literal(token == "true", _at(token))

    def null(self, token: Token) -> Literal:
        return Literal(None, _at(token))

    def computed(self, token: Token) -> Computed:
        return Computed(_at(token))

    def computed_of_parts(self, first: Expression, *parts: object) -> Computed:
        del parts
        return Computed(first.at)

    def sequence(self, bracket: Token, *items: Expression) -> Expression:
        return items[0] if len(items) == 1 else Sequence(items, _at(bracket))

    def operators(self, *parts: Any) -> Operation:
        return Operation(parts[::2], tuple(map(str, parts[1::2])), parts[0].at)

    def unary(self, sign: Token, operand: Expression) -> Unary:
        return Unary(str(sign), operand, _at(sign))

    def quantity(self, number: Expression, bracket: Token, *units: Expression) -> Expression:
        del bracket
        return Quantity(number, units[0], number.at) if len(units) == 1 else Computed(number.at)

    def chained(self, first: Expression, token: Token) -> Expression:
        if isinstance(first, Reference):
            _check_length(first)
            return Reference(first.name, first.at, (*first.steps, (unquoted(token),)))
        return Computed(first.at)

    def named_argument(self, token: Token, value: Expression) -> tuple[str, Expression]:
        return unquoted(token), value

    def arguments(self, bracket: Token, *parts: Any) -> tuple[tuple[str | None, Expression], ...]:
        del bracket
        return tuple(part if isinstance(part, tuple) else (None, part) for part in parts)

    def instance(self, of: Reference, arguments: Any) -> Instance:
        return Instance(of, arguments, of.at)

    def invocation(self, of: Expression, arguments: Any) -> Expression:
        return Instance(of, arguments, of.at) if isinstance(of, Reference) else Computed(of.at)


def _declared(text: str) -> str | None:
    """Return the name that the text of a skipped element declares."""
    for matched in _SKIPPED_NAME.finditer(text):
        if matched[1] is not None:
            return None
        if matched[0] not in WORDS:
            return unquoted(matched[0])
    return None


def _check_length(name: Reference) -> None:
    if len(name.name) + len(name.steps) > _MAX_SEGMENTS:
        raise NotationError(f"a name of more than {_MAX_SEGMENTS} parts; shorten it", name.at)


def _bound(found: Token | Reference) -> int | Reference:
    if isinstance(found, Reference):
        return found
    if not found.isdigit() or len(found) > 9:
        raise NotationError(f"'{found}' is not a number of units; write a whole number", _at(found))
    return int(found)


def _element(kind: str, is_definition: bool, at: int, parts: Several[Any]) -> Element:
    """Build a definition or a usage from what its rule has found, in the order of the text."""
    name = short = bare = multiplicity = value = None
    table: dict[str, list[Reference]] = {}
    for part in parts[:-1]:
        if isinstance(part, Reference):
            at = part.at
            bare = part
            name = part.name[-1]
        elif isinstance(part, Value):
            value = part
        elif len(part) == 3:
            name, short, at = part
        elif part[0] == "[":
            if multiplicity is not None:
                raise NotationError("duplicate multiplicity; keep one", part[1].at)
            multiplicity = part[1]
        else:
            sign, targets = part
            table.setdefault(sign, []).extend(targets)
    if not at:
        at = next((references[0].at for references in table.values() if references), at)
    return Element(
        kind=kind,
        is_definition=is_definition,
        name=name,
        short=short,
        at=at,
        bare=bare,
        types=tuple(table.get(":", ())),
        subsets=tuple(table.get(":>", ())),
        redefines=tuple(table.get(":>>", ())),
        multiplicity=multiplicity,
        value=value,
        members=parts[-1],
    )


def meaningless(problem: NotationError, source: syntax.SourceText) -> HardwareError:
    """Return the error that names the place of a problem."""
    return HardwareError(problem.message, source.location(problem.at))
