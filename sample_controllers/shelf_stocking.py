#!/usr/bin/env python3
"""Stock a shelf with a Franka Emika Panda, planned by MoveItPy (ROS 2).

The robot's configuration comes from the launch file, as parameters of the node `shelf_stocking`.
"""

import rclpy
from geometry_msgs.msg import Pose, PoseStamped
from moveit.core.kinematic_constraints import construct_joint_constraint
from moveit.core.robot_state import RobotState
from moveit.planning import MoveItPy
from moveit_msgs.msg import CollisionObject
from rclpy.logging import get_logger
from shape_msgs.msg import SolidPrimitive

BASE = "panda_link0"
TIP = "panda_link8"

# Joint positions [rad] from which the boxes on the conveyor are seen.
LOOKOUT = {
    "panda_joint1": 0.9,
    "panda_joint2": -0.6,
    "panda_joint3": 0.0,
    "panda_joint4": -2.3,
    "panda_joint5": 0.0,
    "panda_joint6": 1.7,
    "panda_joint7": 0.785,
}


def pose_stamped(x, y, z):
    """A pose of the hand, pointing down."""
    pose = PoseStamped()
    pose.header.frame_id = BASE
    pose.pose.position.x = x
    pose.pose.position.y = y
    pose.pose.position.z = z
    pose.pose.orientation.x = 0.9238795
    pose.pose.orientation.y = -0.3826834
    pose.pose.orientation.w = 0.0
    return pose


class ShelfStocking:
    def __init__(self):
        self.logger = get_logger("shelf_stocking")
        self.moveit = MoveItPy(node_name="shelf_stocking")
        self.arm = self.moveit.get_planning_component("panda_arm")
        self.hand = self.moveit.get_planning_component("hand")
        self.scene_monitor = self.moveit.get_planning_scene_monitor()

    def declare_shelf(self):
        """Tell the planner where the shelf stands."""
        board = SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.30, 0.25, 0.02])
        pose = Pose()
        pose.position.x = 0.45
        pose.position.y = -0.45
        pose.position.z = 0.18
        pose.orientation.w = 1.0

        shelf = CollisionObject()
        shelf.header.frame_id = BASE
        shelf.id = "shelf"
        shelf.primitives.append(board)
        shelf.primitive_poses.append(pose)
        shelf.operation = CollisionObject.ADD
        with self.scene_monitor.read_write() as scene:
            scene.apply_collision_object(shelf)
            scene.current_state.update()

    def look_out(self):
        """Go where the next box can be seen."""
        state = RobotState(self.moveit.get_robot_model())
        state.joint_positions = LOOKOUT
        constraint = construct_joint_constraint(
            robot_state=state,
            joint_model_group=self.moveit.get_robot_model().get_joint_model_group("panda_arm"),
        )
        self.arm.set_start_state_to_current_state()
        self.arm.set_goal_state(motion_plan_constraints=[constraint])
        self.plan_and_execute(self.arm)

    def fetch_box(self):
        """Take a box from the conveyor."""
        self.set_hand("open")
        self.move_to(0.45, 0.35, 0.45)
        self.move_to(0.45, 0.35, 0.33)
        self.set_hand("close")
        self.move_to(0.45, 0.35, 0.45)

    def put_on_shelf(self, row):
        """Put the box into a row of the shelf."""
        self.move_to(0.40 + 0.08 * row, -0.42, 0.55)
        self.move_to(0.40 + 0.08 * row, -0.42, 0.45)
        self.set_hand("open")
        self.move_to(0.40 + 0.08 * row, -0.42, 0.55)

    def park(self):
        """Go to the ready pose."""
        self.arm.set_start_state_to_current_state()
        self.arm.set_goal_state(configuration_name="ready")
        self.plan_and_execute(self.arm)

    def move_to(self, x, y, z):
        self.arm.set_start_state_to_current_state()
        self.arm.set_goal_state(pose_stamped_msg=pose_stamped(x, y, z), pose_link=TIP)
        self.plan_and_execute(self.arm)

    def set_hand(self, configuration):
        self.hand.set_start_state_to_current_state()
        self.hand.set_goal_state(configuration_name=configuration)
        self.plan_and_execute(self.hand)

    def plan_and_execute(self, component):
        plan_result = component.plan()
        if not plan_result:
            raise RuntimeError("planning failed")
        self.moveit.execute(plan_result.trajectory, controllers=[])


def main():
    rclpy.init()
    stocking = ShelfStocking()
    stocking.declare_shelf()
    for row in range(2):
        stocking.look_out()
        stocking.fetch_box()
        stocking.put_on_shelf(row)
        stocking.logger.info(f"row {row + 1} is stocked")
    stocking.park()
    stocking.moveit.shutdown()


if __name__ == "__main__":
    main()
