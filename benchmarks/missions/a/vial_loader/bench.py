"""Where things are on the bench."""
import math

from geometry_msgs.msg import Pose


class Bench(object):
    def __init__(self, config):
        self._tray = config["tray"]
        self._rotor = config["rotor"]
        self.clear = config["heights"]["clear"]
        self.grip = config["heights"]["grip"]
        self.seat = config["heights"]["seat"]
        self.speed = config["speed"]

    def tray(self, index):
        x, y = self._tray["origin"]
        return x + index * self._tray["pitch_x"], y

    def slot(self, index):
        """Slots are numbered counter-clockwise, slot 0 is farthest from the base."""
        angle = 2 * math.pi * index / self._rotor["slots"]
        cx, cy = self._rotor["centre"]
        return cx + self._rotor["radius"] * math.cos(angle), cy + self._rotor["radius"] * math.sin(angle)

    @staticmethod
    def pose(xy, height):
        """Tool straight down, fingers along y."""
        pose = Pose()
        pose.position.x, pose.position.y = xy
        pose.position.z = height
        pose.orientation.x = 1.0
        pose.orientation.w = 0.0
        return pose
