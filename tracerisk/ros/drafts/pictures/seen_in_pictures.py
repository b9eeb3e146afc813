"""What a source looks for in the pictures of a camera: a marker of a dictionary, or a colour."""

from __future__ import annotations

import ast
import colorsys
import re
from collections.abc import Iterator
from dataclasses import dataclass

from tracerisk.errors import Location
from tracerisk.instrument.source.dotted_names import dotted_name, last_name
from tracerisk.instrument.source.literals.called_functions import source_tree

_DICTIONARY = re.compile(r"DICT_\w+")
_NUMBER = re.compile(r"(^|_)ids?$|(marker|tag|aruco)_?(id|number)", re.IGNORECASE)
_BOX = re.compile(r"Detection2D(Array)?|BoundingBox(es|2D)?|bbox", re.IGNORECASE)
_FAMILIES = {
    "tag36h11": "DICT_APRILTAG_36h11",
    "tag36h10": "DICT_APRILTAG_36h10",
    "tag25h9": "DICT_APRILTAG_25h9",
    "tag16h5": "DICT_APRILTAG_16h5",
}
"""Dictionaries of OpenCV, by the name that detectors of AprilTags give them."""


@dataclass(frozen=True, slots=True)
class Seen:
    """What a source looks for in pictures: a marker or a colour."""

    dictionary: str = ""
    """OpenCV's name of the marker's dictionary; empty for a colour."""
    number: int = 0
    """The number of the marker in the dictionary."""
    color: tuple[int, int, int] = (0, 0, 0)
    """Red, green and blue, each 0 to 255, (3,); used without a dictionary."""

    @property
    def words(self) -> str:
        """What is seen, in words."""
        if self.dictionary:
            return f"marker {self.number} of {self.dictionary} in three places"
        return f"a disc of the colour {list(self.color)} in three places"


def seen_in_pictures(place: Location | None) -> Seen | None:
    """Return what the source at `place` looks for in pictures; None where it names nothing."""
    tree = source_tree(place)
    if tree is None:
        return None
    dictionary = next(_dictionaries(tree), "")
    if dictionary:
        return Seen(dictionary, next(_numbers(tree), 0))
    color = next(_colors(tree), None)
    return None if color is None else Seen(color=color)


def takes_pixels(place: Location | None) -> bool:
    """Return whether the source at `place` gets places in pictures from other nodes."""
    tree = source_tree(place)
    names = (last_name(node) for node in ast.walk(tree)) if tree is not None else ()
    return any(_BOX.fullmatch(name) for name in names)


def _dictionaries(tree: ast.Module) -> Iterator[str]:
    """Yield the dictionaries: those given to a call first, then texts, then any other."""
    nodes = list(ast.walk(tree))
    calls = [argument for node in nodes if isinstance(node, ast.Call) for argument in node.args]
    yield from (name for call in calls if _DICTIONARY.fullmatch(name := last_name(call)))
    keys = {id(key) for node in nodes if isinstance(node, ast.Dict) for key in node.keys}
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in keys:
            if _DICTIONARY.fullmatch(node.value):
                yield node.value
            elif node.value in _FAMILIES:
                yield _FAMILIES[node.value]
    yield from (name for node in nodes if _DICTIONARY.fullmatch(name := last_name(node)))


def _numbers(tree: ast.Module) -> Iterator[int]:
    """Yield the numbers of markers: compared with one, or given to a name or a parameter of one."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            sides = (node.left, node.comparators[0])
            for one, other in (sides, sides[::-1]):
                if _is_number_of(one):
                    yield from _whole(other)
        elif isinstance(node, ast.Assign) and any(map(_is_number_of, node.targets)):
            yield from _whole(node.value)
        elif isinstance(node, ast.Call) and node.args:
            first = node.args[0]
            if isinstance(first, ast.Constant) and _NUMBER.search(str(first.value)):
                given = [*node.args[1:2], *(k.value for k in node.keywords if k.arg == "default")]
                yield from (number for item in given for number in _whole(item))


def _is_number_of(node: ast.expr) -> bool:
    while isinstance(node, ast.Subscript):
        node = node.value
    return _NUMBER.search(last_name(node)) is not None


def _whole(node: ast.expr) -> Iterator[int]:
    parts = node.elts if isinstance(node, ast.List | ast.Tuple | ast.Set) else [node]
    for part in parts:
        if isinstance(part, ast.Constant) and type(part.value) is int and part.value >= 0:
            yield part.value


def _colors(tree: ast.Module) -> Iterator[tuple[int, int, int]]:
    """Yield the colours in the middle between the bounds of `inRange`."""
    nodes = list(ast.walk(tree))
    named = {
        dotted_name(target): node.value
        for node in nodes
        if isinstance(node, ast.Assign)
        for target in node.targets
        if dotted_name(target)
    }
    changes = [name for node in nodes if "HSV" in (name := last_name(node))]
    for node in nodes:
        if not isinstance(node, ast.Call) or last_name(node.func) != "inRange":
            continue
        bounds = [
            _levels(named.get(dotted_name(argument), argument)) for argument in node.args[1:3]
        ]
        if len(bounds) != 2 or not all(len(bound) == 3 for bound in bounds):
            continue
        first, second, third = ((a + b) / 2 for a, b in zip(*bounds, strict=True))
        if changes:
            # OpenCV halves the angle of the hue [deg].
            parts = colorsys.hsv_to_rgb(first / 180, second / 255, third / 255)
            red, green, blue = (round(255 * part) for part in parts)
        else:
            blue, green, red = round(first), round(second), round(third)
        yield red, green, blue


def _levels(node: ast.expr) -> list[float]:
    """Return the numbers of `np.array([1, 2, 3])`, or of a list or tuple; none for another."""
    if isinstance(node, ast.Call) and node.args:
        node = node.args[0]
    parts = node.elts if isinstance(node, ast.List | ast.Tuple) else []
    values = [part.value for part in parts if isinstance(part, ast.Constant)]
    return [float(value) for value in values if isinstance(value, int | float)]
