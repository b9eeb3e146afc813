"""Text on its ground has the contrast that WCAG 2.2 asks for at level AA, in both schemes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import tracerisk.report.html as room

CSS = (Path(room.__file__).parent / "assets" / "page.css").read_text(encoding="utf-8")
COLOURS = {
    name: (light, dark)
    for name, light, dark in re.findall(r"--([\w-]+): light-dark\((#\w{6}), (#\w{6})\)", CSS)
}
GROUNDS = ("ground", "paper")
CODE = ("comment", "string", "keyword", "literal", "defined", "ink", "muted")
PAIRS = [
    *((text, ground) for text in ("ink", "muted", "accent", "fail") for ground in GROUNDS),
    *((text, "raised") for text in ("ink", "muted")),
    *((text, "chosen") for text in ("ink", "muted", "accent")),
    *((text, ground) for text in CODE for ground in ("paper", "block", "chosen")),
]
"""Which text stands on which ground."""
SHAPES = ["moving", "holding", "grasping", "borderline", "fail", "muted", "accent", "block-edge"]
"""What is drawn, and must stand out from its ground by 3 to 1."""


def luminance(colour: str) -> float:
    channels = (int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5))
    parts = [
        each / 12.92 if each <= 0.04045 else ((each + 0.055) / 1.055) ** 2.4 for each in channels
    ]
    return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2]


def contrast(one: str, other: str) -> float:
    """Relative luminance and contrast as in WCAG 2.2."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_black_on_white_has_the_greatest_contrast():
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)


@pytest.mark.parametrize("scheme", [0, 1])
@pytest.mark.parametrize(("text", "ground"), PAIRS)
def test_text_stands_out(text, ground, scheme):
    assert contrast(COLOURS[text][scheme], COLOURS[ground][scheme]) >= 4.5


@pytest.mark.parametrize("scheme", [0, 1])
@pytest.mark.parametrize("shape", SHAPES)
def test_shapes_stand_out(shape, scheme):
    assert contrast(COLOURS[shape][scheme], COLOURS["paper"][scheme]) >= 3.0
