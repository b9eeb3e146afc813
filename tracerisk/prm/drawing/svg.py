"""Scalable vector graphics as text: shapes, words and their escaping."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

FONT = "font-family='sans-serif' font-size='12'"
INK, PAPER, FAINT, ALARM = "#222222", "#ffffff", "#888888", "#b3261e"
WORD_HEIGHT = 16.0
_CHARACTER = 6.6
_LONGEST = 28


def word_width(text: str) -> float:
    """Return about how wide a word is drawn, [px]."""
    return _CHARACTER * len(shortened(text))


def shortened(text: str) -> str:
    """Return a name that is short enough for a drawing."""
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


class Canvas:
    """A drawing that grows; coordinates are taken as written, text is escaped."""

    def __init__(self) -> None:
        self._parts: list[str] = []

    def path(self, path: str, *, stroke: str = INK, marks: str = "") -> None:
        """Draw a path in SVG's own notation."""
        self._parts.append(f"<path d='{path}' stroke='{stroke}' fill='none'{marks}/>")

    def line(
        self,
        points: Sequence[tuple[float, float]],
        *,
        arrow: bool = False,
        stroke: str = INK,
        dashed: bool = False,
    ) -> None:
        """Draw a line through points."""
        marks = " marker-end='url(#arrow)'" if arrow else ""
        marks += " stroke-dasharray='4 3'" if dashed else ""
        self.path(
            "M" + " L".join(f"{_n(x)} {_n(y)}" for x, y in points), stroke=stroke, marks=marks
        )

    def box(
        self,
        x: float,
        y: float,
        width: float,
        height: float,
        *,
        radius: float = 0.0,
        stroke: str = INK,
        fill: str = PAPER,
    ) -> None:
        """Draw a rectangle around a centre."""
        self._parts.append(
            f"<rect x='{_n(x - width / 2)}' y='{_n(y - height / 2)}' width='{_n(width)}' "
            f"height='{_n(height)}' rx='{_n(radius)}' stroke='{stroke}' fill='{fill}'/>"
        )

    def circle(self, x: float, y: float, radius: float) -> None:
        """Draw a circle."""
        self._parts.append(
            f"<circle cx='{_n(x)}' cy='{_n(y)}' r='{_n(radius)}' stroke='{INK}' fill='{PAPER}'/>"
        )

    def word(
        self, x: float, y: float, text: str, *, anchor: str = "middle", fill: str = INK
    ) -> None:
        """Write a text around a point; a long one is shortened, and whole in its tooltip."""
        short = shortened(text)
        title = f"<title>{escape(text)}</title>" if short != text else ""
        self._parts.append(
            f"<text x='{_n(x)}' y='{_n(y + 4)}' text-anchor='{anchor}' fill='{fill}' stroke='none'>"
            f"{escape(short)}{title}</text>"
        )

    def svg(self, width: float, height: float, title: str, *, margin: float = 12.0) -> str:
        """Return the document; `width` and `height` are those of the drawing, [px]."""
        wide, high = width + 2 * margin, height + 2 * margin
        arrow = (
            "<defs><marker id='arrow' viewBox='0 0 8 8' refX='8' refY='4' markerWidth='7' "
            f"markerHeight='7' orient='auto'><path d='M0 0 L8 4 L0 8 z' fill='{INK}' "
            "stroke='none'/></marker></defs>"
        )
        return (
            f"<svg xmlns='http://www.w3.org/2000/svg' width='{_n(wide)}' height='{_n(high)}' "
            f"viewBox='{_n(-margin)} {_n(-margin)} {_n(wide)} {_n(high)}' {FONT}>"
            f"<title>{escape(title)}</title>{arrow}"
            f"<rect x='{_n(-margin)}' y='{_n(-margin)}' width='{_n(wide)}' height='{_n(high)}' "
            f"fill='{PAPER}'/>{''.join(self._parts)}</svg>"
        )


def _n(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")
