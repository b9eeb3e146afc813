"""Read the looks that are shipped."""

from __future__ import annotations

import functools
import re
from pathlib import Path

from tracerisk.common.text.yaml_reader import YamlMap, read_large_yaml
from tracerisk.errors import RobotError
from tracerisk.twin.looks.look import Look, Piece

SHIPPED_LOOKS = Path(__file__).parent / "shipped"
"""Where the files of the looks are."""

_COLOUR = re.compile(r"#[0-9a-f]{6}")


@functools.cache
def shipped_looks() -> tuple[Look, ...]:
    """Return all looks, by the names of their files."""
    return tuple(read_look(path) for path in sorted(SHIPPED_LOOKS.glob("*.yaml")))


def read_look(path: Path) -> Look:
    """Read a look; raises RobotError with file and line where the file is malformed."""
    top = read_large_yaml(path, RobotError, shown=f"looks/{path.name}")
    top.forbid_unknown({"made_for", "source", "paints", "links"})
    paints = {"shell": ""}
    colours = top.map("paints")
    for name in colours:
        paints[name] = colours.string(name)
        if not _COLOUR.fullmatch(paints[name]):
            colours.fail(name, "a colour is # and six of the digits 0-9 and a-f, such as #e9ebee")
    links = top.map("links")
    return Look(
        name=path.stem,
        made_for=top.string("made_for"),
        source=top.string("source"),
        links={name: tuple(_piece(entry, paints) for entry in links.maps(name)) for name in links},
    )


def _piece(entry: YamlMap, paints: dict[str, str]) -> Piece:
    entry.forbid_unknown({"tube", "flat", "box", "edge", "xyz", "rpy", "paint", "joint"})
    if ("tube" in entry) == ("box" in entry):
        entry.fail("tube", "a piece is either a tube or a box")
    tube = entry.numbers("tube") if "tube" in entry else []
    if len(tube) % 4 or any(radius <= 0.0 for radius in tube[3::4]):
        entry.fail("tube", "each point has four numbers, x, y, z and a radius above 0")
    return Piece(
        tube=tuple(tube),
        is_flat=entry.boolean("flat", default=False),
        box=tuple(entry.numbers("box", length=3)) if "box" in entry else (),
        edge=entry.number("edge") if "edge" in entry else None,
        xyz=entry.triple("xyz"),
        rpy=entry.triple("rpy"),
        paint=paints[entry.choice("paint", paints, "paint", default="shell")],
        is_joint=entry.boolean("joint", default=False),
    )
