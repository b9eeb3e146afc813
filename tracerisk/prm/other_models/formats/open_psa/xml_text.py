"""Elements as XML text, one line each."""

from __future__ import annotations

from collections.abc import Iterator

from tracerisk.prm.other_models.formats.open_psa.stochastic import Node
from tracerisk.prm.other_models.logic.model import Place

TEXT = ""
"""The key under which the text of an element stands among its attributes."""


def document(root: Node) -> str:
    """Return the XML file of an element."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', *_lines(root, "")]
    return "\n".join(lines) + "\n"


def notes(place: Place) -> list[Node]:
    """Return the label and the attributes of what stands at a place."""
    nodes: list[Node] = []
    if place.label:
        nodes.append(("label", {TEXT: place.label}, []))
    if place.attributes:
        attributes: list[Node] = [
            (
                "attribute",
                {"name": attribute.name, "value": attribute.value}
                | ({"type": attribute.type} if attribute.type else {}),
                [],
            )
            for attribute in place.attributes
        ]
        nodes.append(("attributes", {}, attributes))
    return nodes


def _lines(node: Node, indent: str) -> Iterator[str]:
    # It brings half of the standard library with it, which a reader does not need.
    from xml.sax.saxutils import escape, quoteattr

    tag, attributes, children = node
    if TEXT in attributes:
        yield f"{indent}<{tag}>{escape(attributes[TEXT])}</{tag}>"
        return
    written = "".join(f" {name}={quoteattr(value)}" for name, value in attributes.items())
    if not children:
        yield f"{indent}<{tag}{written}/>"
        return
    yield f"{indent}<{tag}{written}>"
    for child in children:
        yield from _lines(child, indent + "  ")
    yield f"{indent}</{tag}>"
