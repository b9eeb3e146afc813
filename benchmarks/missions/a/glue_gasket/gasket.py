#!/usr/bin/env python3
"""Dispense a gasket: a closed bead along a rectangle, then dots along its middle line.  Lite 6, nozzle at the flange."""
import contextlib
import copy

import moveit_commander
import rospy
from std_msgs.msg import Float32
from std_srvs.srv import Trigger

LITE6 = "lite6"
ABOVE = 0.04       # free height over the surface [m]
PURGE_STATION = [0.8, 0.30, 1.05, 0.0, 0.75, 0.0]
FIRST_CORNER = [-0.2, 0.35, 1.15, 0.0, 0.80, -0.2]


def trigger(name):
    service = rospy.ServiceProxy("/dispenser/" + name, Trigger)
    service.wait_for_service(5.0)

    def call():
        answer = service()
        if not answer.success:
            raise rospy.ServiceException("dispenser: cannot %s" % name)
    return call


def offset(pose, dx=0.0, dy=0.0, dz=0.0):
    moved = copy.deepcopy(pose)
    moved.position.x += dx
    moved.position.y += dy
    moved.position.z += dz
    return moved


def rectangle(corner, length, width):
    """The corners after the first one, and the first one again."""
    yield offset(corner, dx=width)
    yield offset(corner, dx=width, dy=length)
    yield offset(corner, dy=length)
    yield corner


def dot_places(corner, length, width, number):
    pitch = length / (number + 1)
    for i in range(1, number + 1):
        yield offset(corner, dx=width / 2, dy=i * pitch)


class Nozzle:
    def __init__(self):
        self.group = moveit_commander.MoveGroupCommander(LITE6)
        self.group.set_max_velocity_scaling_factor(0.4)
        self.group.set_max_acceleration_scaling_factor(0.4)
        self.open, self.close = trigger("open"), trigger("close")
        self.laid = rospy.Publisher("/dispenser/laid", Float32, queue_size=10)

    @contextlib.contextmanager
    def flow(self):
        self.open()
        try:
            yield
        finally:
            self.close()

    def joints(self, values):
        self.group.go(values, wait=True)
        self.group.stop()

    @property
    def pose(self):
        return self.group.get_current_pose().pose

    def along(self, poses, factor=0.3):
        poses = list(poses)
        path, fraction = self.group.compute_cartesian_path(poses, 0.004)
        if fraction < 0.995:
            raise RuntimeError("path of %d points ends at %.0f %%" % (len(poses), 100 * fraction))
        path = self.group.retime_trajectory(self.group.get_current_state(), path, factor, factor)
        self.group.execute(path, wait=True)

    def dot(self, place, seconds):
        self.along([offset(place, dz=ABOVE), place])
        with self.flow():
            rospy.sleep(seconds)
        self.along([offset(place, dz=ABOVE)])
        self.laid.publish(seconds)


def main():
    rospy.init_node("gasket")
    length = rospy.get_param("~length")
    width = rospy.get_param("~width")
    dots = rospy.get_param("~dots")
    speed = rospy.get_param("~speed", 0.05)
    nozzle = Nozzle()

    nozzle.joints(PURGE_STATION)
    trigger("purge")()

    nozzle.joints(FIRST_CORNER)
    surface = offset(nozzle.pose, dz=-ABOVE)
    nozzle.along([surface])
    with nozzle.flow():
        nozzle.along(rectangle(surface, length, width), factor=speed)
    nozzle.laid.publish(2 * (length + width))
    nozzle.along([offset(surface, dz=ABOVE)])

    for place in dot_places(surface, length, width, dots):
        nozzle.dot(place, 0.5)

    nozzle.group.set_named_target("home")
    nozzle.group.go(wait=True)
    rospy.loginfo("gasket is laid, %d dots", dots)


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass
