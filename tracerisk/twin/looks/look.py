"""The look of a robot: pieces that are drawn of each link, and never simulated."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from tracerisk.common.geometry.shapes import Mesh

Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Piece:
    """A piece of a link in the link's frame: a tube, a box or a mesh."""

    tube: tuple[float, ...] = ()
    """Points along the middle of a tube, each with the radius there, (4 n_points,) [m]."""
    is_flat: bool = False
    """Whether the ends of a tube are flat; else they are balls."""
    box: tuple[float, ...] = ()
    """Half lengths of a box, (3,) [m]."""
    edge: float | None = None
    """How much of a box's edges is cut off [m]; `None` for a little."""
    xyz: Point = (0.0, 0.0, 0.0)
    """Place of a box's middle, or of a mesh [m]."""
    rpy: Point = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw of a box or mesh [rad]."""
    mesh: Mesh | None = None
    """A mesh of the robot's model, in the frame that `xyz` and `rpy` place."""
    paint: str = ""
    """Colour as `#rrggbb`; "" for the page's own colour of robots."""
    is_joint: bool = False
    """Whether it is the housing of a drive, which shows what the drive does."""


@dataclass(frozen=True, slots=True)
class Look:
    """How one robot looks, and by that others that are built alike."""

    name: str
    """Name of the look's file."""
    made_for: str
    """Name of the shipped robot whose lengths the pieces have."""
    source: str
    """Where lengths and colours are from."""
    links: Mapping[str, tuple[Piece, ...]] = field(default_factory=dict)
    """Pieces of each link, by the end of the link's name."""


def scaled(pieces: Iterable[Piece], along: Point, across: float) -> tuple[Piece, ...]:
    """Return pieces as long as `along` says for each axis, and as thick as `across` says."""
    return tuple(
        Piece(
            tube=tuple(
                value * (along[index % 4] if index % 4 < 3 else across)
                for index, value in enumerate(piece.tube)
            ),
            is_flat=piece.is_flat,
            box=tuple(value * across for value in piece.box),
            edge=None if piece.edge is None else piece.edge * across,
            xyz=(piece.xyz[0] * along[0], piece.xyz[1] * along[1], piece.xyz[2] * along[2]),
            rpy=piece.rpy,
            paint=piece.paint,
            is_joint=piece.is_joint,
        )
        for piece in pieces
    )


def is_called(link: str, name: str) -> bool:
    """Return whether a link is called so, whatever stands before its name."""
    return link == name or link.endswith((f"_{name}", f"/{name}"))
