#!/usr/bin/env python3
"""Lift cartons off a stack with the suction cup of a Lite 6 (ROS 1, smach).

In the Gazebo cell the cup is the link attacher.
"""
import sys

import moveit_commander
import rospy
import smach
from gazebo_ros_link_attacher.srv import Attach, AttachRequest
from geometry_msgs.msg import Pose
from std_srvs.srv import Trigger

STACK = (0.24, -0.15)
THICKNESS = 0.03
GAP = 0.001
CUP_LENGTH = 0.052     # of the bellows, below link_tcp
OVER_STACK = [-0.56, 0.35, 1.06, 0.0, 0.71, 0.0]
CLEAR = 0.08
CUP = ("lite6", "link_eef")


class Cell:
    """What all states share."""

    def __init__(self):
        self.group = moveit_commander.MoveGroupCommander("lite6")
        self.group.set_max_velocity_scaling_factor(0.8)
        self.group.set_max_acceleration_scaling_factor(0.8)
        self.cartons = rospy.get_param("~cartons")
        self.target = rospy.get_param("~target")
        self.attach = rospy.ServiceProxy("/link_attacher_node/attach", Attach)
        self.detach = rospy.ServiceProxy("/link_attacher_node/detach", Attach)
        self.vacuum = rospy.ServiceProxy("/vacuum/check", Trigger)

    def cup_at(self, x, y, z):
        pose = Pose()
        pose.position.x, pose.position.y, pose.position.z = x, y, z + CUP_LENGTH
        pose.orientation.x = 1.0
        self.group.set_pose_target(pose)
        done = self.group.go(wait=True)
        self.group.stop()
        self.group.clear_pose_targets()
        return done

    def joint(self, number):
        request = AttachRequest()
        request.model_name_1, request.link_name_1 = CUP
        request.model_name_2 = "carton_%d" % number
        request.link_name_2 = "link"
        return request


class CellState(smach.State):
    def __init__(self, cell, outcomes, **keys):
        smach.State.__init__(self, outcomes=outcomes, **keys)
        self.cell = cell


class Next(CellState):
    def __init__(self, cell):
        CellState.__init__(self, cell, ["more", "empty"], input_keys=["left"], output_keys=["left", "carton"])

    def execute(self, userdata):
        if userdata.left == 0:
            return "empty"
        userdata.carton = userdata.left
        userdata.left -= 1
        return "more"


class Lift(CellState):
    def __init__(self, cell):
        CellState.__init__(self, cell, ["lifted", "leak"], input_keys=["carton"])

    def execute(self, userdata):
        top = userdata.carton * THICKNESS
        x, y = STACK
        self.cell.cup_at(x, y, top + CLEAR)
        self.cell.cup_at(x, y, top + GAP)
        self.cell.attach(self.cell.joint(userdata.carton))
        if not self.cell.vacuum().success:
            return "leak"
        self.cell.cup_at(x, y, top + CLEAR)
        return "lifted"


class Lay(CellState):
    def __init__(self, cell):
        CellState.__init__(self, cell, ["laid"], input_keys=["carton"])

    def execute(self, userdata):
        target = self.cell.target
        place = self.cell.cartons - userdata.carton
        x, y = target["x"] + place * target["pitch"], target["y"]
        self.cell.cup_at(x, y, THICKNESS + CLEAR)
        self.cell.cup_at(x, y, THICKNESS + 2 * GAP)
        self.cell.detach(self.cell.joint(userdata.carton))
        rospy.sleep(0.2)
        self.cell.cup_at(x, y, THICKNESS + CLEAR)
        return "laid"


class Park(CellState):
    def __init__(self, cell):
        CellState.__init__(self, cell, ["parked"])

    def execute(self, userdata):
        self.cell.group.set_named_target("home")
        self.cell.group.go(wait=True)
        return "parked"


def main():
    rospy.init_node("destack")
    moveit_commander.roscpp_initialize(sys.argv)
    cell = Cell()
    cell.group.go(OVER_STACK, wait=True)
    machine = smach.StateMachine(outcomes=["done", "failed"])
    machine.userdata.left = cell.cartons
    with machine:
        smach.StateMachine.add("NEXT", Next(cell), {"more": "LIFT", "empty": "PARK"})
        smach.StateMachine.add("LIFT", Lift(cell), {"lifted": "LAY", "leak": "failed"})
        smach.StateMachine.add("LAY", Lay(cell), {"laid": "NEXT"})
        smach.StateMachine.add("PARK", Park(cell), {"parked": "done"})
    return machine.execute()


if __name__ == "__main__":
    sys.exit(0 if main() == "done" else 1)
