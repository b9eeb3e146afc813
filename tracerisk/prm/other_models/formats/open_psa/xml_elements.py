"""XML as elements with their positions, one definition at a time.

Entities are refused where they are declared, external parts are never loaded, and what a handler
has taken is let go, so that a file of any size fits.
"""

from __future__ import annotations

import pyexpat as expat
from collections.abc import Callable

from tracerisk.common.text.bounded import named_file
from tracerisk.errors import Location, ModelError, one_of

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import BinaryIO, NoReturn


GREATEST_DEPTH = 200
"""How deep elements may nest; what reads them recurses."""


class Element:
    """An element: its tag, attributes, children and text, and where it starts."""

    __slots__ = ("attributes", "children", "column", "file", "line", "tag", "text")

    def __init__(
        self, tag: str, attributes: dict[str, str], file: str, line: int, column: int
    ) -> None:
        self.tag = tag
        self.attributes = attributes
        self.children: list[Element] = []
        self.file = file
        self.line = line
        self.column = column
        self.text = ""

    @property
    def location(self) -> Location:
        """Where the element starts."""
        return Location(self.file, self.line, self.column + 1)

    def fail(self, message: str) -> NoReturn:
        """Raise ModelError at the element."""
        raise ModelError(message, self.location)

    def attribute(self, name: str) -> str:
        """Return an attribute, or raise ModelError when it is missing or empty."""
        value = self.attributes.get(name, "")
        if not value.strip():
            self.fail(f"<{self.tag}> has no {name}; give it one")
        return value.strip()

    def check_attributes(self, *allowed: str) -> None:
        """Raise ModelError when the element has another attribute than those."""
        for name in self.attributes:
            if name not in allowed:
                self.fail(
                    f"<{self.tag}> has the unknown attribute '{name}'; {one_of(allowed, name)}"
                )

    def one_child(self) -> Element:
        """Return the only child, or raise ModelError when there are none or several."""
        if len(self.children) != 1:
            self.fail(f"<{self.tag}> contains {len(self.children)} elements; allowed: one")
        return self.children[0]

    def unexpected(self, allowed: object) -> NoReturn:
        """Raise ModelError for an element that does not belong where it stands."""
        names = sorted(str(name) for name in allowed)  # type: ignore[attr-defined]
        self.fail(f"<{self.tag}> does not belong here; {one_of(names, self.tag)}")


def parse(
    source: str | bytes,
    file: str,
    roots: tuple[str, ...],
    containers: frozenset[str],
    enter: Callable[[Element], None],
    take: Callable[[Element], None],
    include: Callable[[Element], None] | None = None,
) -> Element:
    """Parse XML, the bytes or the path of a file, and return its root.

    `file` is its name in messages. A root with one of the names `roots` is read by the first of
    them, and its namespace, with or without a prefix, is left aside.

    `enter` is called with each container, `take` with each child of one once it is whole, and
    with the container itself after those; its label and attributes stay in it. `include` is
    called with each `xi:include` in a container. Attributes of other namespaces are left out.
    Raises ModelError, with the position, when the file cannot be read, is not XML, declares
    entities or nests too deep.
    """
    parser = expat.ParserCreate()
    parser.SetParamEntityParsing(expat.XML_PARAM_ENTITY_PARSING_NEVER)
    parser.buffer_text = True
    stack: list[Element] = []
    whole: list[Element] = []
    prefix = ""
    kept = frozenset(("label", "attributes"))

    def here() -> Location:
        return Location(file, parser.CurrentLineNumber, parser.CurrentColumnNumber + 1)

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal prefix
        if not stack:
            prefix = tag[: tag.find(":") + 1]
            attributes.pop("xmlns", None)
        if prefix:
            tag = tag.removeprefix(prefix)
        if not stack and tag in roots:
            tag = roots[0]
        if attributes:
            if ":" in "".join(attributes):
                attributes = {name: value for name, value in attributes.items() if ":" not in name}
            name = attributes.get("name", "x")
            if name and (name[0] <= " " or name[-1] <= " "):
                attributes = {key: value.strip() for key, value in attributes.items()}
        element = Element(
            tag, attributes, file, parser.CurrentLineNumber, parser.CurrentColumnNumber
        )
        if len(stack) > GREATEST_DEPTH:
            element.fail(f"elements nest more than {GREATEST_DEPTH} deep; flatten the model")
        stack.append(element)
        if tag in containers:
            enter(element)
        elif tag == "label":
            parser.CharacterDataHandler = text

    def end(tag: str) -> None:
        element = stack.pop()
        if prefix:
            tag = tag.removeprefix(prefix)
        if tag == "label":
            parser.CharacterDataHandler = None
        if not stack:
            whole.append(element)
        parent = stack[-1] if stack else None
        if tag == "xi:include" and include is not None:
            include(element)
        elif parent is None or (parent.tag in containers and tag not in kept):
            take(element)
        else:
            parent.children.append(element)

    def text(data: str) -> None:
        stack[-1].text += data

    def refuse_entity(*_: object) -> None:
        raise ModelError("declares an entity; write out what it stands for", here())

    def refuse_reference(name: str, *_: object) -> None:
        raise ModelError(f"refers to the entity '{name}'; write out what it stands for", here())

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.EntityDeclHandler = refuse_entity
    parser.SkippedEntityHandler = refuse_reference
    try:
        if isinstance(source, bytes):
            parser.Parse(source, True)
        else:
            with named_file(source) as stream:
                parser.ParseFile(stream)
    except expat.ExpatError as error:
        place = Location(file, error.lineno, error.offset + 1)
        raise ModelError(_explain(parser, source, error), place) from error
    except OSError as error:
        raise ModelError(f"cannot be read: {error.strerror or error}", Location(file)) from error
    finally:
        # The handlers refer to the parser, and the parser to them.
        parser.StartElementHandler = parser.EndElementHandler = None
        parser.CharacterDataHandler = None
        parser.EntityDeclHandler = parser.SkippedEntityHandler = None
    return whole[0]


def _explain(parser: expat.XMLParserType, source: str | bytes, error: expat.ExpatError) -> str:
    index = parser.ErrorByteIndex
    if error.code == expat.errors.codes[expat.errors.XML_ERROR_NO_ELEMENTS] and index <= 0:
        return "is empty; expected an XML file"
    if error.code == expat.errors.codes[expat.errors.XML_ERROR_INVALID_TOKEN]:
        byte = _byte(source, index)
        if byte and byte[0] >= 0x80:
            return (
                f"the byte 0x{byte.hex().upper()} is not valid here; save the file as UTF-8, or "
                "state its encoding in the XML declaration"
            )
    reason = expat.ErrorString(error.code)
    return f"is not well-formed XML: {reason}; is the file truncated?"


def _byte(source: str | bytes, index: int) -> bytes:
    if isinstance(source, bytes):
        return source[index : index + 1]
    stream: BinaryIO
    with named_file(source) as stream:
        stream.seek(max(index, 0))
        return stream.read(1)
