"""Drawings that take their colours from the page: elements, and what they have in common."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement, tostring

from markupsafe import Markup

from tracerisk.prm.drawing.svg import shortened

Point = tuple[float, float]
_MARGIN = 8.0
CHARACTER = 7.2
"""The width of a character of the drawings' monospaced font, [px]."""


class Drawing:
    """A drawing that grows; texts and attributes are escaped as it is written.

    `name` is the id under which its title is known; no two drawings of a page share one.
    """

    def __init__(self, name: str, title: str, description: str) -> None:
        self._root = Element(
            "svg",
            {"role": "img", "aria-labelledby": f"{name}-title {name}-desc", "class": "drawing"},
        )
        SubElement(self._root, "title", {"id": f"{name}-title"}).text = title
        SubElement(self._root, "desc", {"id": f"{name}-desc"}).text = description
        self._name = name
        self._has_arrows = False
        # Lines lie below what they join.
        self._lines = SubElement(self._root, "g")
        self._shapes = SubElement(self._root, "g")

    def group(self, kind: str, **data: str) -> Element:
        """Return a new group above the lines, with `data-` attributes."""
        return SubElement(
            self._shapes,
            "g",
            {"class": kind, **{f"data-{name}": value for name, value in data.items()}},
        )

    def path(self, way: str, kind: str, *, arrow: bool = False, **data: str) -> None:
        """Draw a line in SVG's own notation, below the shapes."""
        attributes = {"d": way, "class": kind}
        if arrow:
            attributes["marker-end"] = f"url(#{self._name}-arrow)"
            self._has_arrows = True
        attributes |= {f"data-{name}": value for name, value in data.items()}
        SubElement(self._lines, "path", attributes)

    def markup(self, width: float, height: float) -> Markup:
        """Return the drawing as HTML; `width` and `height` are those of what was drawn, [px]."""
        wide, high = width + 2 * _MARGIN, height + 2 * _MARGIN
        self._root.set("width", number(wide))
        self._root.set("height", number(high))
        self._root.set("viewBox", " ".join(map(number, (-_MARGIN, -_MARGIN, wide, high))))
        if self._has_arrows:
            self._add_arrow()
        return Markup(tostring(self._root, encoding="unicode"))

    def _add_arrow(self) -> None:
        marker = Element(
            "marker",
            {
                "id": f"{self._name}-arrow",
                "viewBox": "0 0 8 8",
                "refX": "7",
                "refY": "4",
                "markerWidth": "7",
                "markerHeight": "7",
                "orient": "auto",
            },
        )
        SubElement(marker, "path", {"d": "M0 0.8 L8 4 L0 7.2 z", "fill": "context-stroke"})
        self._root.insert(2, marker)


def box(parent: Element, centre: Point, width: float, height: float, kind: str = "") -> None:
    """Draw a rectangle around a centre."""
    x, y = centre
    SubElement(
        parent,
        "rect",
        {
            "x": number(x - width / 2),
            "y": number(y - height / 2),
            "width": number(width),
            "height": number(height),
            "rx": "6",
            "class": kind or "shape",
        },
    )


def circle(parent: Element, centre: Point, radius: float, kind: str = "shape") -> None:
    """Draw a circle."""
    x, y = centre
    SubElement(
        parent, "circle", {"cx": number(x), "cy": number(y), "r": number(radius), "class": kind}
    )


def word(parent: Element, x: float, y: float, text: str, kind: str, anchor: str = "middle") -> None:
    """Write a text beside or around a point; a long one is shortened, and whole in its tooltip."""
    short = shortened(text)
    element = SubElement(
        parent,
        "text",
        {"x": number(x), "y": number(y + 4), "text-anchor": anchor, "class": kind},
    )
    element.text = short
    if short != text:
        SubElement(element, "title").text = text


def add_title(parent: Element, text: str) -> None:
    """Give a group a tooltip, which is read out where drawings are."""
    title = Element("title")
    title.text = text
    parent.insert(0, title)


def text_width(text: str) -> float:
    """Return how wide a word is drawn, [px]."""
    return CHARACTER * len(shortened(text))


def number(value: float) -> str:
    """Return a coordinate, to a tenth of a pixel."""
    return f"{value:.1f}".removesuffix(".0")
