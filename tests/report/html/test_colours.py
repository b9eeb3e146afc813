"""Text on its ground has the contrast of WCAG 2.2 at level AA; states are told apart, whoever looks."""

import math
import re
from itertools import combinations
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


STATES = ("moving", "holding", "grasping", "fail")
"""What is told apart by colour; `fail` is that of an unexpected contact beside one expected."""
APART = 0.15
"""How far two colours are to be in OKLab; 0.02 can just be seen."""

# Linear RGB as it looks to who lacks a kind of cone: G. M. Machado, M. M. Oliveira,
# L. A. F. Fernandes (2009), severity 1.
SIGHTS = {
    "full": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "protan": (
        (0.152286, 1.052583, -0.204868),
        (0.114503, 0.786281, 0.099216),
        (-0.003882, -0.048116, 1.051998),
    ),
    "deutan": (
        (0.367322, 0.860646, -0.227968),
        (0.280085, 0.672501, 0.047413),
        (-0.011820, 0.042940, 0.968881),
    ),
    "tritan": (
        (1.255528, -0.076749, -0.178779),
        (-0.078411, 0.930809, 0.147602),
        (0.004733, 0.691367, 0.303900),
    ),
}
# B. Ottosson (2020): linear RGB to cones, and their cube roots to OKLab.
_TO_CONES = (
    (0.4122214708, 0.5363325363, 0.0514459929),
    (0.2119034982, 0.6806995451, 0.1073969566),
    (0.0883024619, 0.2817188376, 0.6299787005),
)
_TO_LAB = (
    (0.2104542553, 0.7936177850, -0.0040720468),
    (1.9779984951, -2.4285922050, 0.4505937099),
    (0.0259040371, 0.7827717662, -0.8086757660),
)


def times(matrix, vector):
    return [sum(a * b for a, b in zip(row, vector, strict=True)) for row in matrix]


def linear(colour: str) -> list[float]:
    channels = (int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5))
    return [
        each / 12.92 if each <= 0.04045 else ((each + 0.055) / 1.055) ** 2.4 for each in channels
    ]


def luminance(colour: str) -> float:
    return sum(a * b for a, b in zip((0.2126, 0.7152, 0.0722), linear(colour), strict=True))


def seen(colour: str, sight: str) -> list[float]:
    """A colour in OKLab, as it looks to someone."""
    looks = [min(max(each, 0.0), 1.0) for each in times(SIGHTS[sight], linear(colour))]
    return times(
        _TO_LAB, [math.copysign(abs(each) ** (1 / 3), each) for each in times(_TO_CONES, looks)]
    )


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


def test_red_and_green_come_near_one_another_without_a_cone():
    full, lacking = (math.dist(seen("#a05000", s), seen("#5a7000", s)) for s in ("full", "deutan"))
    assert lacking < 0.5 * full


@pytest.mark.parametrize("sight", SIGHTS)
@pytest.mark.parametrize("scheme", [0, 1])
def test_states_are_reported_apart_by_whoever_looks(scheme, sight):
    for one, other in combinations(STATES, 2):
        places = (seen(COLOURS[each][scheme], sight) for each in (one, other))
        assert math.dist(*places) >= APART, (one, other)


def test_pictures_have_the_colours_of_the_page():
    from tracerisk.report.png.pictures import KIND_COLOURS, STATE_COLOURS

    assert all(STATE_COLOURS[state] == COLOURS[state][0] for state in STATES[:3])
    timeline = (Path(room.__file__).parent / "assets" / "timeline.css").read_text(encoding="utf-8")
    for kind, colour in KIND_COLOURS.items():
        assert f"--replay-{kind}: light-dark({colour}, " in timeline
