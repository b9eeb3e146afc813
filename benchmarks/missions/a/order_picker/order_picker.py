#!/usr/bin/env python3
"""Node that picks ordered items off a shelf and puts them into totes (Panda, MoveGroup action, ROS 2).

An order on /orders reads "ITEM:TOTE"; "close" ends the shift when all orders are done.
"""
import queue
import re
import threading

import rclpy
from control_msgs.action import GripperCommand
from geometry_msgs.msg import Pose
from moveit_msgs.action import MoveGroup
from moveit_msgs.msg import Constraints, JointConstraint, OrientationConstraint, PositionConstraint
from rclpy.action import ActionClient
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import String
from std_srvs.srv import Trigger

SHELF = {"A": 0.20, "B": 0.30}              # y of the shelf's rows
COLUMN_1, COLUMN_PITCH = 0.40, 0.10
TOTES = {"1": (0.45, -0.20), "2": (0.55, -0.20)}
ORDER = re.compile(r"^([AB])([12]):([12])$")
READY = {"panda_joint1": 0.0, "panda_joint2": -0.7854, "panda_joint3": 0.0, "panda_joint4": -2.3562,
         "panda_joint5": 0.0, "panda_joint6": 1.5708, "panda_joint7": 0.7854}
GRIP, TRAVEL = 0.035, 0.20


class OrderPicker(Node):
    def __init__(self):
        super().__init__("order_picker")
        self.orders = queue.Queue()
        self.create_subscription(String, "/orders", self.on_order, 10)
        self.done = self.create_publisher(String, "/orders/done", 10)
        self.booking = self.create_client(Trigger, "/shelf/booked")
        self.move_group = ActionClient(self, MoveGroup, "/move_action")
        self.gripper = ActionClient(self, GripperCommand, "/panda_hand_controller/gripper_cmd")

    def on_order(self, message):
        match = ORDER.match(message.data)
        if match:
            self.orders.put(match.groups())
        elif message.data == "close":
            self.orders.put(None)
        else:
            self.get_logger().warning(f"no order: {message.data!r}")

    # --------------------------------------------------------------- motion
    def act(self, client, goal):
        """Send a goal from the worker's thread; wait for its result."""
        finished, box = threading.Event(), []

        def on_result(future):
            box.append(future.result().result)
            finished.set()

        def on_accepted(future):
            future.result().get_result_async().add_done_callback(on_result)

        client.wait_for_server()
        client.send_goal_async(goal).add_done_callback(on_accepted)
        if not finished.wait(30.0):
            raise TimeoutError("no result")
        return box[0]

    def plan_and_go(self, constraints, scale=0.6):
        goal = MoveGroup.Goal()
        goal.request.group_name = "panda_manipulator"
        goal.request.num_planning_attempts = 5
        goal.request.allowed_planning_time = 2.0
        goal.request.max_velocity_scaling_factor = scale
        goal.request.max_acceleration_scaling_factor = scale
        goal.request.goal_constraints.append(constraints)
        result = self.act(self.move_group, goal)
        if result.error_code.val != result.error_code.SUCCESS:
            raise RuntimeError(f"move_group: {result.error_code.val}")

    def tool_to(self, xy, z, scale=0.6):
        pose = Pose()
        pose.position.x, pose.position.y = xy
        pose.position.z = z
        pose.orientation.w = 1.0
        where = PositionConstraint(link_name="panda_hand_tcp", weight=1.0)
        where.header.frame_id = "panda_link0"
        where.constraint_region.primitives.append(SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[0.0005]))
        where.constraint_region.primitive_poses.append(pose)
        turned = OrientationConstraint(link_name="panda_hand_tcp", weight=1.0)
        turned.header.frame_id = "panda_link0"
        turned.orientation.x, turned.orientation.w = 1.0, 0.0
        turned.absolute_x_axis_tolerance = 0.005
        turned.absolute_y_axis_tolerance = 0.005
        turned.absolute_z_axis_tolerance = 0.005
        self.plan_and_go(Constraints(position_constraints=[where], orientation_constraints=[turned]), scale)

    def ready(self):
        self.plan_and_go(Constraints(joint_constraints=[
            JointConstraint(joint_name=n, position=q, tolerance_above=0.001, tolerance_below=0.001, weight=1.0)
            for n, q in READY.items()]))

    def fingers(self, position, effort=15.0):
        goal = GripperCommand.Goal()
        goal.command.position, goal.command.max_effort = position, effort
        return self.act(self.gripper, goal)

    # --------------------------------------------------------------- orders
    def fetch(self, row, column):
        xy = (COLUMN_1 + COLUMN_PITCH * (int(column) - 1), SHELF[row])
        self.fingers(0.035)
        self.tool_to(xy, TRAVEL)
        self.tool_to(xy, GRIP, 0.3)
        gripped = self.fingers(0.0)
        self.tool_to(xy, TRAVEL, 0.3)
        return gripped.stalled

    def deliver(self, tote):
        self.tool_to(TOTES[tote], TRAVEL)
        self.tool_to(TOTES[tote], GRIP + 0.002, 0.3)
        self.fingers(0.035)
        self.tool_to(TOTES[tote], TRAVEL, 0.3)

    def work(self):
        self.ready()
        for order in iter(self.orders.get, None):
            row, column, tote = order
            if not self.fetch(row, column):
                self.get_logger().error(f"{row}{column} is not there")
                continue
            self.deliver(tote)
            self.booking.call(Trigger.Request())
            self.done.publish(String(data=f"{row}{column}"))
            self.ready()


def main():
    rclpy.init()
    node = OrderPicker()
    executor = MultiThreadedExecutor(num_threads=3)
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    worker = threading.Thread(target=node.work)
    worker.start()
    worker.join()
    executor.shutdown()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
