#!/usr/bin/env python3
"""Fill a kit with an FR3: a behaviour tree over MoveItPy (ROS 2)."""
from dataclasses import dataclass

import rclpy
from geometry_msgs.msg import PoseStamped
from moveit.planning import MoveItPy, PlanRequestParameters
from std_msgs.msg import String
from std_srvs.srv import Trigger

from bt import Do, Fallback, Inverter, Retry, Sequence, Status


@dataclass(frozen=True)
class Part:
    name: str
    pick: tuple         # x, y, height of the grip
    slot: tuple         # x, y in the kit
    open: float = 0.035


PARTS = (
    Part("handle", (0.42, -0.24, 0.022), (0.42, 0.12)),
    Part("knob", (0.50, -0.20, 0.028), (0.52, 0.12)),
    Part("plate", (0.56, -0.28, 0.016), (0.42, 0.26)),
)
HOVER = 0.14
PLACE_GAP = 0.002


class Cell:
    """Actions of the tree."""

    def __init__(self):
        self.node = rclpy.create_node("kit_clients")
        self.moveit = MoveItPy(node_name="kitting")
        self.arm = self.moveit.get_planning_component("fr3_manipulator")
        self.hand = self.moveit.get_planning_component("hand")
        self.weigh_client = self.node.create_client(Trigger, "/scale/weigh")
        self.release_client = self.node.create_client(Trigger, "/kit/release")
        self.added = self.node.create_publisher(String, "/kit/added", 10)
        self.contents = []

    def plan_and_go(self, component, pace=0.5):
        parameters = PlanRequestParameters(self.moveit, "")
        parameters.max_velocity_scaling_factor = pace
        parameters.max_acceleration_scaling_factor = pace
        plan = component.plan(single_plan_parameters=parameters)
        if not plan:
            return False
        return bool(self.moveit.execute(plan.trajectory, controllers=[]))

    def tip_to(self, x, y, z, pace=0.5):
        goal = PoseStamped()
        goal.header.frame_id = "fr3_link0"
        goal.pose.position.x = x
        goal.pose.position.y = y
        goal.pose.position.z = z
        goal.pose.orientation.x = 1.0
        goal.pose.orientation.w = 0.0
        self.arm.set_start_state_to_current_state()
        self.arm.set_goal_state(pose_stamped_msg=goal, pose_link="fr3_hand_tcp")
        return self.plan_and_go(self.arm, pace)

    def hand_to(self, state):
        self.hand.set_start_state_to_current_state()
        self.hand.set_goal_state(configuration_name=state)
        return self.plan_and_go(self.hand, 1.0)

    def ready(self):
        self.arm.set_start_state_to_current_state()
        self.arm.set_goal_state(configuration_name="ready")
        return self.plan_and_go(self.arm)

    def in_kit(self, part):
        return part.name in self.contents

    def note(self, part):
        self.contents.append(part.name)
        self.added.publish(String(data=part.name))

    def ask(self, client):
        future = client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(self.node, future)
        return future.result().success


class PickAndPlace(Sequence):
    """Brings one part into its slot."""

    def __init__(self, cell, part):
        x, y, z = part.pick
        sx, sy = part.slot
        super().__init__("bring " + part.name, [
            Do("open", cell.hand_to, "open"),
            Do("over the part", cell.tip_to, x, y, HOVER),
            Do("down", cell.tip_to, x, y, z, 0.25),
            Do("close", cell.hand_to, "close"),
            Do("lift", cell.tip_to, x, y, HOVER, 0.25),
            Do("over the slot", cell.tip_to, sx, sy, HOVER),
            Do("lower", cell.tip_to, sx, sy, z + PLACE_GAP, 0.25),
            Do("release", cell.hand_to, "open"),
            Do("leave", cell.tip_to, sx, sy, HOVER, 0.25),
            Retry("weigh", Do("scale", cell.ask, cell.weigh_client), 3),
            Do("note", cell.note, part),
        ])


def build(cell):
    steps = [Do("ready", cell.ready)]
    for part in PARTS:
        steps.append(Fallback("have " + part.name, [
            Do("in kit?", cell.in_kit, part),
            PickAndPlace(cell, part),
        ]))
    steps += [
        Do("park", cell.ready),
        Inverter("kit incomplete?", Do("missing", lambda: len(cell.contents) < len(PARTS))),
        Do("release the kit", cell.ask, cell.release_client),
    ]
    return Sequence("fill the kit", steps)


def main():
    rclpy.init()
    cell = Cell()
    status = build(cell).tick()
    if status is Status.FAILURE:
        cell.node.get_logger().error("the kit is not complete")
    cell.moveit.shutdown()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
