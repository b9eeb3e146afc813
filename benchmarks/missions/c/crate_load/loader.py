#!/usr/bin/env python3
"""Loads cartons from the conveyor into a crate around a post: Panda, MoveItPy, behaviour tree (ROS 2)."""
from dataclasses import dataclass

import rclpy
from geometry_msgs.msg import Pose, PoseStamped
from moveit.planning import MoveItPy
from moveit_msgs.msg import CollisionObject
from rclpy.node import Node
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import Bool, Float32, String, UInt16
from std_srvs.srv import SetBool

from bt import Do, Fallback, Sequence, Twice

FLANGE_ABOVE_FINGERS = 0.1034


@dataclass(frozen=True)
class Spot:
    x: float
    y: float
    z: float

    def raised(self, by):
        return Spot(self.x, self.y, self.z + by)


@dataclass(frozen=True)
class Carton:
    name: str
    at: Spot
    cell: int


CRATE = {1: Spot(0.40, -0.30, 0.055), 2: Spot(0.50, -0.30, 0.055)}
CARTONS = (
    Carton("carton_a", Spot(0.46, 0.28, 0.085), 2),
    Carton("carton_b", Spot(0.36, 0.28, 0.085), 1),
)


class Loader(Node):
    def __init__(self):
        super().__init__("crate_cell")
        self.moveit = MoveItPy(node_name="loader")
        self.arm = self.moveit.get_planning_component("panda_arm")
        self.hand = self.moveit.get_planning_component("hand")
        self.moved = self.create_publisher(String, "/wms/moved", 10)
        self.fill = self.create_publisher(UInt16, "/crate/fill", 10)
        self.advance = self.create_publisher(Float32, "/conveyor/advance_mm", 10)
        self.alarm = self.create_publisher(Bool, "/cell/alarm", 10)
        self.stopper = self.create_client(SetBool, "/conveyor/stopper")
        self.stopper.wait_for_service()
        self.loaded = 0

    def declare_post(self):
        post = CollisionObject()
        post.header.frame_id = "panda_link0"
        post.id = "post"
        post.primitives.append(SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.06, 0.06, 0.30]))
        pose = Pose()
        pose.position.x, pose.position.y, pose.position.z = 0.58, 0.0, 0.15
        pose.orientation.w = 1.0
        post.primitive_poses.append(pose)
        post.operation = CollisionObject.ADD
        with self.moveit.get_planning_scene_monitor().read_write() as scene:
            scene.apply_collision_object(post)
            scene.current_state.update()

    def run_plan(self, component):
        plan = component.plan()
        if not plan:
            return False
        self.moveit.execute(plan.trajectory, controllers=[])
        return True

    def go(self, spot):
        target = PoseStamped()
        target.header.frame_id = "panda_link0"
        target.pose.position.x, target.pose.position.y = spot.x, spot.y
        target.pose.position.z = spot.z + FLANGE_ABOVE_FINGERS
        target.pose.orientation.x, target.pose.orientation.y = 0.9238795, -0.3826834
        target.pose.orientation.w = 0.0
        self.arm.set_start_state_to_current_state()
        self.arm.set_goal_state(pose_stamped_msg=target, pose_link="panda_link8")
        return self.run_plan(self.arm)

    def named(self, component, state):
        component.set_start_state_to_current_state()
        component.set_goal_state(configuration_name=state)
        return self.run_plan(component)

    def stop_belt(self, shut):
        future = self.stopper.call_async(SetBool.Request(data=shut))
        rclpy.spin_until_future_complete(self, future)
        return future.result().success

    def book(self, carton):
        self.loaded += 1
        self.moved.publish(String(data=f"{carton.name}>{carton.cell}"))
        self.fill.publish(UInt16(data=self.loaded))

    def index_belt(self):
        self.advance.publish(Float32(data=100.0))

    def tree(self):
        steps = [Do("post", self.declare_post), Do("ready", self.named, self.arm, "ready")]
        for carton in CARTONS:
            place = CRATE[carton.cell]
            steps.append(Sequence(
                carton.name,
                Do("stopper", self.stop_belt, True),
                Do("open", self.named, self.hand, "open"),
                Twice(Do("over the belt", self.go, carton.at.raised(0.12))),
                Do("at the carton", self.go, carton.at),
                Do("close", self.named, self.hand, "close"),
                Do("lift", self.go, carton.at.raised(0.16)),
                Do("let go of the belt", self.stop_belt, False),
                Do("index", self.index_belt),
                Twice(Do("over the crate", self.go, place.raised(0.18))),
                Do("into the crate", self.go, place.raised(0.002)),
                Do("release", self.named, self.hand, "open"),
                Do("book", self.book, carton),
                Do("out of the crate", self.go, place.raised(0.18)),
            ))
        steps.append(Do("park", self.named, self.arm, "ready"))
        return Fallback("mission", Sequence("load", *steps), Do("alarm", self.raise_alarm))

    def raise_alarm(self):
        self.alarm.publish(Bool(data=True))
        return False


def main():
    rclpy.init()
    loader = Loader()
    loader.tree()(loader.get_logger())
    loader.moveit.shutdown()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
