"""Geometry of the panel in front of the Doosan, in mm of its base; tool angles ZYZ in degrees."""
from dataclasses import dataclass
from typing import Iterator, List

TOOL_DOWN = [0.0, 180.0, 0.0]


@dataclass
class Panel:
    x: float            # centre
    y: float
    height: float       # of the surface
    length: float       # along y
    depth: float        # along x
    stripes: int = 4
    overrun: float = 30.0
    distance: float = 120.0

    @property
    def pitch(self) -> float:
        return self.depth / (self.stripes - 1)

    def pose(self, x: float, y: float, lift: float = 0.0) -> List[float]:
        return [x, y, self.height + self.distance + lift] + TOOL_DOWN

    def stripe_ends(self) -> Iterator[tuple]:
        """Begin and end of each stripe, alternately left to right and back."""
        half = self.length / 2 + self.overrun
        for number in range(self.stripes):
            x = self.x - self.depth / 2 + number * self.pitch
            side = -1 if number % 2 == 0 else 1
            yield self.pose(x, self.y + side * half), self.pose(x, self.y - side * half)
