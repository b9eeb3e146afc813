#!/usr/bin/env python3
"""A service that plans and executes a pick with a Panda (MoveIt, ROS 1)."""
import sys

import moveit_commander
import rospy
from std_srvs.srv import Trigger, TriggerResponse

ABOVE = [0.4, -0.3, 0.0, -2.2, 0.0, 1.9, 1.2]
AT = [0.4, 0.05, 0.0, -2.2, 0.0, 2.25, 1.2]


class PlanServer:
    def __init__(self):
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.arm.set_max_velocity_scaling_factor(0.4)
        self.arm.set_named_target("ready")
        self.arm.go(wait=True)
        rospy.loginfo("ready")
        self.service = rospy.Service("/plan_pick", Trigger, self.on_request)

    def plan_to(self, joints):
        self.arm.set_joint_value_target(joints)
        plan = self.arm.plan()
        if not plan.joint_trajectory.points:
            raise RuntimeError("no trajectory to %s" % joints)
        return plan

    def on_request(self, _):
        response = TriggerResponse()
        for joints in (ABOVE, AT, ABOVE):
            plan = self.plan_to(joints)
            if not self.arm.execute(plan, wait=True):
                response.message = "not executed"
                return response
        response.success = True
        response.message = "picked"
        rospy.loginfo("picked")
        return response


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("plan_server")
    PlanServer()
    rospy.spin()


if __name__ == "__main__":
    main()
