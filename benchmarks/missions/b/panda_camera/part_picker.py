#!/usr/bin/env python
"""Pick what the camera finds and bring it to its bin (ROS 1).

The vision node broadcasts a frame per part and announces the part by name; a worker thread
takes the names from a queue so that the callback returns at once.
"""
import threading
from contextlib import contextmanager

try:
    import queue
except ImportError:      # Python 2
    import Queue as queue

import actionlib
import moveit_commander
import rospy
import tf
from franka_gripper.msg import GraspAction, GraspGoal, MoveAction, MoveGoal
from std_msgs.msg import String
from std_srvs.srv import Trigger
from tf.transformations import quaternion_from_euler

BASE = "panda_link0"
TRAVEL_Z = 0.22
STOP = object()


class PartPicker(object):
    def __init__(self):
        self.bins = rospy.get_param("~bins")
        self.widths = rospy.get_param("~widths")
        self.wanted = set(self.bins)
        self.jobs = queue.Queue()
        self.listener = tf.TransformListener()
        self.group = moveit_commander.MoveGroupCommander("panda_manipulator")
        self.group.set_end_effector_link("panda_hand_tcp")
        self.grasp = actionlib.SimpleActionClient("/franka_gripper/grasp", GraspAction)
        self.open = actionlib.SimpleActionClient("/franka_gripper/move", MoveAction)
        for client in (self.grasp, self.open):
            client.wait_for_server()
        self.refresh = rospy.ServiceProxy("/vision/refresh", Trigger)
        self.report = rospy.Publisher("/part_picker/delivered", String, queue_size=5)
        self.worker = threading.Thread(target=self.work)
        self.worker.start()
        rospy.Subscriber("/vision/found", String, self.on_found)

    def on_found(self, msg):
        if msg.data not in self.wanted:
            rospy.logwarn("nothing to do with %s", msg.data)
            return
        self.wanted.discard(msg.data)
        self.jobs.put(msg.data)
        if not self.wanted:
            self.jobs.put(STOP)

    @contextmanager
    def pace(self, velocity, acceleration):
        self.group.set_max_velocity_scaling_factor(velocity)
        self.group.set_max_acceleration_scaling_factor(acceleration)
        yield
        self.group.set_max_velocity_scaling_factor(0.5)
        self.group.set_max_acceleration_scaling_factor(0.5)

    def go_to(self, x, y, z):
        q = quaternion_from_euler(3.14159265, 0.0, 0.0)
        self.group.set_pose_target([x, y, z] + list(q))
        if not self.group.go(wait=True):
            raise RuntimeError("no way to %.3f %.3f %.3f" % (x, y, z))
        self.group.stop()

    def locate(self, name):
        frame = "part_" + name
        self.listener.waitForTransform(BASE, frame, rospy.Time(0), rospy.Duration(4.0))
        position, _ = self.listener.lookupTransform(BASE, frame, rospy.Time(0))
        return position

    def set_width(self, width):
        self.open.send_goal_and_wait(MoveGoal(width=width, speed=0.1), rospy.Duration(4.0))

    def fetch(self, name):
        x, y, z = self.locate(name)
        self.set_width(0.078)
        self.go_to(x, y, TRAVEL_Z)
        with self.pace(0.2, 0.2):
            self.go_to(x, y, z)
            goal = GraspGoal(width=self.widths[name], speed=0.05, force=20.0)
            goal.epsilon.inner = goal.epsilon.outer = 0.006
            self.grasp.send_goal_and_wait(goal, rospy.Duration(5.0))
            held = self.grasp.get_result().success
            self.go_to(x, y, TRAVEL_Z)
        return z, held

    def deliver(self, name, height):
        x, y = self.bins[name]
        self.go_to(x, y, TRAVEL_Z)
        with self.pace(0.2, 0.2):
            self.go_to(x, y, height + 0.002)
        self.set_width(0.078)
        self.go_to(x, y, TRAVEL_Z)
        self.report.publish(name)

    def work(self):
        with self.pace(0.5, 0.5):
            pass
        while not rospy.is_shutdown():
            name = self.jobs.get()
            if name is STOP:
                break
            height, held = self.fetch(name)
            if held:
                self.deliver(name, height)
            self.refresh()
        self.group.set_named_target("ready")
        self.group.go(wait=True)
        rospy.signal_shutdown("all parts are delivered")


if __name__ == "__main__":
    rospy.init_node("part_picker")
    PartPicker()
    rospy.spin()
