#!/usr/bin/env python3
"""Drive a UR3e to a joint position with the velocity controller and a proportional law."""
import sys

import rospy
from controller_manager_msgs.srv import SwitchController, SwitchControllerRequest
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

# shoulder_pan, shoulder_lift, elbow, wrist_1, wrist_2, wrist_3
TARGET = [0.8, -1.4, 1.2, -1.3, -1.5, 0.3]
GAIN = 1.0
LIMIT = 0.3  # rad/s


class Servo:
    def __init__(self):
        self.positions = None
        self.out = rospy.Publisher("/joint_group_vel_controller/command", Float64MultiArray,
                                   queue_size=1)
        rospy.Subscriber("/joint_states", JointState, self.on_state, queue_size=1)

    def on_state(self, msg):
        self.positions = list(msg.position[:6])

    def use_velocity_controller(self):
        name = "/controller_manager/switch_controller"
        rospy.wait_for_service(name)
        switch = rospy.ServiceProxy(name, SwitchController)
        return switch(start_controllers=["joint_group_vel_controller"],
                      stop_controllers=["scaled_pos_joint_traj_controller"],
                      strictness=SwitchControllerRequest.STRICT).ok

    def errors(self):
        return [goal - now for goal, now in zip(TARGET, self.positions)]

    def run(self, seconds):
        rate = rospy.Rate(50)
        end = rospy.Time.now() + rospy.Duration(seconds)
        while rospy.Time.now() < end and not rospy.is_shutdown():
            command = [max(-LIMIT, min(LIMIT, GAIN * e)) for e in self.errors()]
            self.out.publish(Float64MultiArray(data=command))
            rate.sleep()
        self.out.publish(Float64MultiArray(data=[0.0] * 6))


def main():
    rospy.init_node("ur_vel_servo")
    servo = Servo()
    rospy.wait_for_message("/joint_states", JointState)
    rospy.sleep(0.2)
    if not servo.use_velocity_controller():
        rospy.logerr("no velocity controller")
        return 1
    servo.run(12.0)
    rospy.sleep(0.5)
    worst = max(abs(e) for e in servo.errors())
    rospy.loginfo("worst error %.3f rad: %s", worst, "there" if worst < 0.02 else "missed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
