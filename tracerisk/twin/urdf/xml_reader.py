"""Read XML without its dangers: no document type, no entities, bounded in size and depth."""

from __future__ import annotations

import re
import xml.parsers.expat
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NoReturn

from tracerisk.common.geometry.frames import Triple
from tracerisk.errors import Location, RobotError, one_of

MOST_BYTES = 16 * 1024 * 1024
MOST_ELEMENTS = 200_000
_DEEPEST = 200
_ZERO: Triple = (0.0, 0.0, 0.0)


@dataclass(slots=True)
class XmlElement:
    """An XML element."""

    tag: str
    """The tag with its prefix, such as `xacro:include`."""
    attributes: dict[str, str]
    """The value of each attribute."""
    location: Location
    """The file and line where the element begins."""
    children: list[XmlElement] = field(default_factory=list)
    """The elements directly inside, in order."""
    text: str = ""
    """The characters directly inside."""

    def all(self, tag: str) -> Iterator[XmlElement]:
        """Yield the children with a tag."""
        return (child for child in self.children if child.tag == tag)

    def first(self, tag: str) -> XmlElement | None:
        """Return the first child with a tag, `None` where there is none."""
        return next(self.all(tag), None)

    def fail(self, message: str) -> NoReturn:
        """Raise a RobotError at this element."""
        raise RobotError(f"<{self.tag}>: {message}", self.location)

    def string(self, name: str) -> str:
        """Return an attribute; raise RobotError when it is missing or empty."""
        value = self.attributes.get(name, "").strip()
        if not value:
            self.fail(f"has no attribute '{name}'; {one_of(self.attributes, name)}")
        return value

    def number(self, name: str, default: float | None = None) -> float:
        """Return an attribute as a number; raise RobotError when it is none."""
        if default is not None and name not in self.attributes:
            return default
        return self._numbers(name, 1)[0]

    def triple(self, name: str, default: Triple) -> Triple:
        """Return an attribute of three numbers, or the default where it is missing."""
        if name not in self.attributes:
            return default
        x, y, z = self._numbers(name, 3)
        return x, y, z

    def placing(self) -> tuple[Triple, Triple]:
        """Return `xyz` and `rpy` of the element's `<origin>`, zeros where they are missing."""
        origin = self.first("origin")
        if origin is None:
            return _ZERO, _ZERO
        return origin.triple("xyz", _ZERO), origin.triple("rpy", _ZERO)

    def _numbers(self, name: str, length: int) -> list[float]:
        text = self.string(name)
        try:
            values = [float(part) for part in text.split()]
        except ValueError:
            values = []
        if len(values) != length or any(abs(value) > 1e9 or value != value for value in values):
            what = "a number" if length == 1 else f"{length} numbers"
            self.fail(f"attribute '{name}' is '{text}'; give {what}, with spaces between them")
        return values


def read_xml(text: str | bytes, file: str) -> XmlElement:
    """Return the root element of an XML text.

    A comment may hold `--`, and lasts until `-->`, as for the readers of ROS.

    Raises RobotError with file and line when it is not XML, too large, or declares a document type
    (with which a small text can grow without bounds, or name other files).
    """
    data = text.encode() if isinstance(text, str) else text
    if len(data) > MOST_BYTES:
        raise RobotError(f"holds {len(data)} bytes; at most {MOST_BYTES} are read", Location(file))
    try:
        return _parsed(data, file)
    except RobotError:
        bare = _without_comments(data)
        if bare == data:
            raise
    return _parsed(bare, file)


def _without_comments(data: bytes) -> bytes:
    """Return a text with blanks for its comments, all else where it was."""
    parts, at = [], 0
    while (begin := data.find(b"<!--", at)) >= 0:
        end = data.find(b"-->", begin + 4)
        if end < 0:
            break
        comment = data[begin : end + 3]
        parts += [data[at:begin], re.sub(rb"[^\r\n]", b" ", comment)]
        at = end + 3
    return b"".join((*parts, data[at:]))


def _parsed(data: bytes, file: str) -> XmlElement:
    parser = xml.parsers.expat.ParserCreate()
    parser.buffer_text = True
    builder = _Builder(parser, file)
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.characters
    parser.StartDoctypeDeclHandler = builder.doctype
    try:
        parser.Parse(data, True)
    except RobotError:
        raise
    except (LookupError, ValueError) as error:
        # Python knows no such encoding, or not one that a parser can use.
        raise RobotError(f"is not XML that can be read: {error}", Location(file, 1)) from error
    except xml.parsers.expat.ExpatError as error:
        reason = xml.parsers.expat.errors.messages.get(error.code, str(error))
        raise RobotError(
            f"is not XML: {reason}", Location(file, error.lineno, error.offset + 1)
        ) from error
    assert builder.root is not None, "expat refuses a document without elements"
    return builder.root


class _Builder:
    def __init__(self, parser: xml.parsers.expat.XMLParserType, file: str) -> None:
        self.root: XmlElement | None = None
        self._parser = parser
        self._file = file
        self._open: list[XmlElement] = []
        self._count = 0

    def _here(self) -> Location:
        return Location(self._file, self._parser.CurrentLineNumber)

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        element = XmlElement(tag, attributes, self._here())
        self._count += 1
        if self._count > MOST_ELEMENTS:
            element.fail(f"is one too many: at most {MOST_ELEMENTS} elements are read")
        if len(self._open) >= _DEEPEST:
            element.fail(f"stands deeper than {_DEEPEST} elements")
        if self._open:
            self._open[-1].children.append(element)
        else:
            self.root = element
        self._open.append(element)

    def end(self, _tag: str) -> None:
        self._open.pop()

    def characters(self, text: str) -> None:
        self._open[-1].text += text

    def doctype(self, *_: object) -> None:
        raise RobotError(
            "declares a document type, which is not read; take the <!DOCTYPE ...> out",
            self._here(),
        )
