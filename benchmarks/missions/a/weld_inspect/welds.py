"""Views of the welds, joint positions of the UR10e in degrees as read from the pendant."""
from collections import namedtuple
from math import radians

Weld = namedtuple("Weld", ["name", "view"])


def pendant(*degrees):
    return [radians(d) for d in degrees]


HOME = pendant(0, -90, 90, -90, -90, 0)

WELDS = [
    Weld("front left", pendant(35, -75, 100, -115, -90, 0)),
    Weld("front right", pendant(-35, -75, 100, -115, -90, 0)),
    Weld("rear right", pendant(-35, -50, 70, -110, -90, 45)),
    Weld("rear left", pendant(35, -50, 70, -110, -90, -45)),
]

# From a view to where the marker's tip stands on the frame.
MARK_OFFSET = pendant(0, 6, 2, -8, 0, 0)
