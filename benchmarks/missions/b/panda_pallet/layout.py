"""Geometry of the infeed lane and the pallet. No ROS in here."""
import collections

import yaml

Slot = collections.namedtuple("Slot", "x y z")


class Layout(object):
    def __init__(self, path):
        with open(path) as stream:
            self.cfg = yaml.safe_load(stream)
        self.edge = self.cfg["box"]["edge"]
        self.clearance = self.cfg["heights"]["clearance"]

    def grip_height(self, layer=0):
        """Height of the finger tips when they hold a box of this layer."""
        return (layer + 1) * self.edge - self.cfg["box"]["grip_below_top"]

    def infeed(self):
        """Grip points of the boxes in the lane, nearest first."""
        x0, y0 = self.cfg["infeed"]["first"]
        for i in range(self.cfg["infeed"]["count"]):
            yield Slot(x0 + i * self.cfg["infeed"]["pitch"], y0, self.grip_height())

    def pallet(self):
        """Where the boxes go: a layer is filled before the next one begins."""
        pallet = self.cfg["pallet"]
        x0, y0 = pallet["corner"]
        for layer in range(pallet["layers"]):
            for column in range(pallet["columns"]):
                yield Slot(
                    x0 + column * pallet["column_pitch"],
                    y0,
                    self.grip_height(layer) + self.cfg["heights"]["release_gap"],
                )
