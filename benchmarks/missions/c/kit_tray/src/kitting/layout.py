"""Where things are in the kitting cell, seen from panda_link0 [m]."""
from collections import namedtuple

Place = namedtuple("Place", "x y z")
Article = namedtuple("Article", "number lane weight_g width")

# Feeder lanes: the centre of the part at the stop.
LANES = {
    "L1": Place(0.42, -0.22, 0.045),
    "L2": Place(0.50, -0.22, 0.045),
    "L3": Place(0.58, -0.22, 0.045),
}

# Nests of the kit tray; the pitch of the tray is 80 mm by 90 mm.
TRAY_ORIGIN = Place(0.44, 0.16, 0.045)
PITCH_X, PITCH_Y = 0.08, 0.09


def nest(label):
    """'B2' -> the place of that nest."""
    row, column = "AB".index(label[0]), int(label[1:]) - 1
    return Place(TRAY_ORIGIN.x + PITCH_X * column, TRAY_ORIGIN.y + PITCH_Y * row, TRAY_ORIGIN.z)


CATALOGUE = {
    "bracket": Article(number=40117, lane="L1", weight_g=85, width=0.040),
    "spacer": Article(number=40231, lane="L2", weight_g=60, width=0.030),
    "bush": Article(number=40588, lane="L3", weight_g=110, width=0.036),
}

CLEARANCE = 0.12
