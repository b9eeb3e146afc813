#!/usr/bin/env python3
"""Touch the steps of a calibration block with a force-guarded move and report their heights.

UR3e with its wrist sensor, ROS 2. The probing move is one slow trajectory to below the block; it is
cancelled as soon as the wrist feels the surface.
"""
import statistics
import threading

import rclpy
from control_msgs.action import FollowJointTrajectory, GripperCommand
from geometry_msgs.msg import WrenchStamped
from rclpy.action import ActionClient
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.time import Time
from std_msgs.msg import Float64
from std_srvs.srv import Trigger
from tf2_ros import Buffer, TransformListener
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint")

# name: joint angles at 220, 185, 150 and 120 mm of the flange above the base
PROBES = {
    "low_front": ((-0.0513, -1.8722, 2.2179, -1.9157, -1.57, -0.0513),
                  (-0.0513, -1.7896, 2.3450, -2.1254, -1.57, -0.0513),
                  (-0.0513, -1.6566, 2.4525, -2.3659, -1.57, -0.0513),
                  (-0.0513, -1.4962, 2.5241, -2.5979, -1.57, -0.0513)),
    "high": ((-0.0374, -1.5150, 1.9141, -1.9691, -1.57, -0.0374),
             (-0.0374, -1.4420, 2.0184, -2.1465, -1.57, -0.0374),
             (-0.0374, -1.3411, 2.1008, -2.3297, -1.57, -0.0374),
             (-0.0374, -1.2331, 2.1520, -2.4888, -1.57, -0.0374)),
    "low_back": ((0.1667, -1.7259, 2.1122, -1.9564, -1.5699, 0.1667),
                 (0.1667, -1.6447, 2.2288, -2.1543, -1.5699, 0.1667),
                 (0.1667, -1.5241, 2.3243, -2.3704, -1.5699, 0.1667),
                 (0.1667, -1.3878, 2.3858, -2.5682, -1.5699, 0.1667)),
}
HOME = (0.0, -1.5708, 1.2, -1.2, -1.57, 0.0)

FORCE_LIMIT = 8.0       # N above the tare
LEG = 1.4               # s for each of the three legs down
TARE_SAMPLES = 20


class Contact(Exception):
    pass


class StepProbe(Node):
    def __init__(self):
        super().__init__("step_probe")
        group = ReentrantCallbackGroup()
        self.arm = ActionClient(self, FollowJointTrajectory,
                                "/scaled_joint_trajectory_controller/follow_joint_trajectory",
                                callback_group=group)
        self.fingers = ActionClient(self, GripperCommand, "/gripper_controller/gripper_cmd",
                                    callback_group=group)
        self.store = self.create_client(Trigger, "/cmm/store", callback_group=group)
        self.heights = self.create_publisher(Float64, "/cmm/height", 10)
        self.buffer = Buffer()
        self.tf = TransformListener(self.buffer, self)
        self.forces = []
        self.tare = None
        self.touched = threading.Event()
        self.create_subscription(WrenchStamped, "/force_torque_sensor_broadcaster/wrench",
                                 self.on_wrench, 10, callback_group=group)

    def on_wrench(self, msg):
        force = msg.wrench.force.z
        if self.tare is None:
            self.forces.append(force)
        elif abs(force - self.tare) > FORCE_LIMIT:
            self.touched.set()

    def take_tare(self):
        self.tare = None
        self.forces.clear()
        while len(self.forces) < TARE_SAMPLES:
            self.wait(0.05)
        self.tare = statistics.median(self.forces)

    def wait(self, seconds):
        self.get_clock().sleep_for(Duration(seconds=seconds))

    @staticmethod
    def finish(future):
        done = threading.Event()
        future.add_done_callback(lambda _: done.set())
        if not done.wait(30.0):
            raise TimeoutError("no answer")
        return future.result()

    def start(self, poses, leg):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = list(JOINTS)
        for number, pose in enumerate(poses, start=1):
            goal.trajectory.points.append(JointTrajectoryPoint(
                positions=list(pose), time_from_start=Duration(seconds=number * leg).to_msg()))
        return self.finish(self.arm.send_goal_async(goal))

    def move(self, pose, seconds):
        handle = self.start([pose], seconds)
        self.finish(handle.get_result_async())

    def guarded(self, poses):
        """Down until something is felt; the height of the flange there."""
        self.touched.clear()
        handle = self.start(poses, LEG)
        if not self.touched.wait(LEG * len(poses) + 1.0):
            raise Contact("nothing was touched")
        self.finish(handle.cancel_goal_async())
        self.wait(0.3)
        lookup_transform = self.buffer.lookup_transform("base_link", "tool0", Time())
        return lookup_transform.transform.translation.z

    def probe(self, name):
        above, *down = PROBES[name]
        self.move(above, 2.0)
        self.wait(0.5)
        self.take_tare()
        height = self.guarded(down)
        self.heights.publish(Float64(data=height))
        self.finish(self.store.call_async(Trigger.Request()))
        self.move(above, 1.5)
        return height

    def close_fingers(self):
        """The closed fingers are the stylus."""
        self.fingers.wait_for_server()
        goal = GripperCommand.Goal()
        goal.command.position = 0.0
        goal.command.max_effort = 20.0
        handle = self.finish(self.fingers.send_goal_async(goal))
        self.finish(handle.get_result_async())

    def mission(self):
        self.arm.wait_for_server()
        self.close_fingers()
        self.move(HOME, 2.0)
        measured = {name: self.probe(name) for name in ("low_front", "high", "low_back")}
        self.move(HOME, 2.0)
        step = measured["high"] - measured["low_front"]
        self.get_logger().info(f"the step is {1000 * step:.1f} mm")


def main():
    rclpy.init()
    node = StepProbe()
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(node)
    spinner = threading.Thread(target=executor.spin, daemon=True)
    spinner.start()
    try:
        node.mission()
    finally:
        executor.shutdown()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
