#!/usr/bin/env python3
"""Build a tower of three blocks with a Franka Research 3 (MoveItPy, behaviour tree)."""
import rclpy
from geometry_msgs.msg import PoseStamped
from moveit.planning import MoveItPy
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

from tree import Action, Fallback, Retry, Sequence

SIDE = 0.05
HAND_CLEAR = 0.12
SITES = {"red": (0.40, 0.25), "green": (0.50, 0.25), "blue": (0.60, 0.25), "tower": (0.50, -0.10)}
PLAN = ["green", "red", "blue"]         # from the ground up
RELEASE_GAP = 0.002


class Builder:
    def __init__(self):
        self.node = Node("tower_cell")
        self.moveit = MoveItPy(node_name="tower")
        self.arm = self.moveit.get_planning_component("fr3_manipulator")
        self.hand = self.moveit.get_planning_component("hand")
        self.progress = self.node.create_publisher(String, "/tower/progress", 10)
        self.check = self.node.create_client(Trigger, "/tower/check")
        self.height = 0

    # ---- leaves of the tree
    def hand_to(self, name):
        self.hand.set_start_state_to_current_state()
        self.hand.set_goal_state(configuration_name=name)
        return self._go(self.hand)

    def hover(self, site, level):
        return self._tool(SITES[site], self._centre(level) + HAND_CLEAR)

    def descend(self, site, level, gap=0.0):
        return self._tool(SITES[site], self._centre(level) + gap)

    def grown(self, colour):
        self.height += 1
        self.progress.publish(String(data=f"{self.height} {colour}"))

    def checked(self):
        future = self.check.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(self.node, future)
        return future.result().success

    def park(self):
        self.arm.set_start_state_to_current_state()
        self.arm.set_goal_state(configuration_name="ready")
        return self._go(self.arm)

    # ---- below the leaves
    @staticmethod
    def _centre(level):
        return SIDE / 2 + SIDE * level

    def _tool(self, xy, z):
        goal = PoseStamped()
        goal.header.frame_id = "fr3_link0"
        goal.pose.position.x, goal.pose.position.y = xy
        goal.pose.position.z = z
        goal.pose.orientation.x = 1.0
        goal.pose.orientation.w = 0.0
        self.arm.set_start_state_to_current_state()
        self.arm.set_goal_state(pose_stamped_msg=goal, pose_link="fr3_hand_tcp")
        return self._go(self.arm)

    def _go(self, component):
        plan = component.plan()
        if not plan:
            return False
        return bool(self.moveit.execute(plan.trajectory, controllers=[]))


def block(builder, colour, level):
    """The subtree that puts one block on the tower."""
    pick = Sequence(
        Action(builder.hover, colour, 0),
        Action(builder.descend, colour, 0),
        Action(builder.hand_to, "close"),
        Action(builder.hover, colour, 0),
    )
    place = Sequence(
        Action(builder.hover, "tower", level),
        Action(builder.descend, "tower", level, RELEASE_GAP),
        Action(builder.hand_to, "open"),
        Action(builder.hover, "tower", level),
    )
    return Sequence(Action(builder.hand_to, "open"), Retry(pick, 2), place, Action(builder.grown, colour))


def main():
    rclpy.init()
    builder = Builder()
    tree = Sequence(
        *[block(builder, colour, level) for level, colour in enumerate(PLAN)],
        Fallback(Action(builder.park), Action(builder.park)),
        Action(builder.checked),
    )
    ok = tree()
    builder.node.get_logger().info("tower: " + ("built" if ok else "not built"))
    builder.node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
