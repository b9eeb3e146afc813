#!/usr/bin/env python3
"""A UR5e goes home by URScript and lifts its tool by 5 cm from wherever that is."""
import math

import rospy
import tf2_ros
from sensor_msgs.msg import JointState
from std_msgs.msg import String

HOME = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
LIFT = 0.05         # [m]
NEAR = 0.01


def rotation_vector(q):
    """A quaternion as the rotation vector of URScript's poses."""
    length = math.sqrt(q.x ** 2 + q.y ** 2 + q.z ** 2)
    if length < 1e-9:
        return [0.0, 0.0, 0.0]
    angle = 2.0 * math.atan2(length, q.w)
    return [angle * q.x / length, angle * q.y / length, angle * q.z / length]


def numbers(values):
    return "[" + ", ".join("%.5f" % value for value in values) + "]"


class Script:
    def __init__(self):
        self.speed = 1.0
        rospy.Subscriber("/joint_states", JointState, self.on_state)
        self.program = rospy.Publisher(
            "/ur_hardware_interface/script_command", String, queue_size=1)
        self.buffer = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.buffer)
        rospy.sleep(1.0)

    def on_state(self, msg):
        self.speed = max(abs(v) for v in msg.velocity) if msg.velocity else 0.0

    def run(self, line):
        """Send one line, and wait until the arm has moved and rests again."""
        rospy.loginfo("%s", line)
        self.program.publish(String(line))
        rospy.sleep(1.0)
        until = rospy.get_time() + 20.0
        while self.speed > 0.002 and rospy.get_time() < until:
            rospy.sleep(0.1)
        rospy.sleep(0.5)

    def tool(self):
        """The pose of the tool in the base of the robot: x, y, z, rx, ry, rz."""
        transform = self.buffer.lookup_transform(
            "base", "tool0", rospy.Time(0), rospy.Duration(2.0)).transform
        where = transform.translation
        return [where.x, where.y, where.z] + rotation_vector(transform.rotation)


def main():
    rospy.init_node("lift_tool")
    script = Script()
    script.run("movej(%s, a=0.8, v=0.6)" % numbers(HOME))
    begin = script.tool()
    rospy.loginfo("the tool is at %s", numbers(begin))

    above = list(begin)
    above[2] += LIFT
    script.run("movej(%s, a=0.8, v=0.6)" % numbers(above))
    now = script.tool()
    off = math.sqrt(sum((a - b) ** 2 for a, b in zip(now[:3], above[:3])))
    rospy.loginfo("the tool is at %s, %.3f m off", numbers(now), off)
    if off > NEAR:
        raise RuntimeError("the tool was not lifted, it is %.3f m off" % off)
    rospy.loginfo("lifted")


if __name__ == "__main__":
    main()
