"""Plans and moves by move_group: its actions, kinematics, straight lines and the planning scene."""

import rclpy
from geometry_msgs.msg import Pose
from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.msg import CollisionObject, Constraints, JointConstraint, PlanningScene
from moveit_msgs.srv import (
    ApplyPlanningScene,
    GetCartesianPath,
    GetMotionPlan,
    GetPlanningScene,
    GetPositionFK,
    GetPositionIK,
)
from rclpy.action import ActionClient
from rclpy.node import Node
from shape_msgs.msg import SolidPrimitive

READY = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)
ASIDE = (0.4, -0.6, 0.0, -2.2, 0.0, 1.6, 0.785)
TIP = "panda_link8"
SERVICES = {
    "apply_planning_scene": ApplyPlanningScene,
    "compute_cartesian_path": GetCartesianPath,
    "compute_fk": GetPositionFK,
    "compute_ik": GetPositionIK,
    "get_planning_scene": GetPlanningScene,
    "plan_kinematic_path": GetMotionPlan,
}


class Cell(Node):
    def __init__(self):
        super().__init__("cell")
        self.mover = ActionClient(self, MoveGroup, "move_action")
        self.executor_of_plans = ActionClient(self, ExecuteTrajectory, "execute_trajectory")
        self.mover.wait_for_server()
        self.executor_of_plans.wait_for_server()
        # At first: while nodes look for each other, the arm holds still for as long as it takes.
        self.services_of = {name: self.create_client(kind, name) for name, kind in SERVICES.items()}
        for client in self.services_of.values():
            client.wait_for_service()

    def call(self, name, request):
        future = self.services_of[name].call_async(request)
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def result(self, client, goal):
        future = client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, future)
        future = future.result().get_result_async()
        rclpy.spin_until_future_complete(self, future)
        return future.result().result

    def to_joints(self, positions):
        constraints = Constraints()
        for number, position in enumerate(positions, 1):
            joint = JointConstraint(joint_name=f"panda_joint{number}", position=position)
            joint.tolerance_above = joint.tolerance_below = 1e-4
            joint.weight = 1.0
            constraints.joint_constraints.append(joint)
        return constraints

    def request(self, positions):
        goal = MoveGroup.Goal()
        goal.request.group_name = "panda_arm"
        goal.request.allowed_planning_time = 5.0
        goal.request.max_velocity_scaling_factor = 0.5
        goal.request.max_acceleration_scaling_factor = 0.5
        goal.request.start_state.is_diff = True
        goal.request.goal_constraints = [self.to_joints(positions)]
        goal.planning_options.planning_scene_diff.is_diff = True
        return goal

    def aside(self):
        result = self.result(self.mover, self.request(ASIDE))
        print("> moved", result.error_code.val)

    def back(self):
        goal = self.request(READY)
        goal.planning_options.plan_only = True
        planned = self.result(self.mover, goal)
        points = planned.planned_trajectory.joint_trajectory.points
        print("> planned", planned.error_code.val, len(points) > 1)
        goal = ExecuteTrajectory.Goal(trajectory=planned.planned_trajectory)
        print("> executed", self.result(self.executor_of_plans, goal).error_code.val)

    def lower(self):
        request = GetCartesianPath.Request(group_name="panda_arm", link_name=TIP, max_step=0.01)
        request.start_state.is_diff = True
        pose = self.where()
        pose.position.z -= 0.1
        request.waypoints, request.avoid_collisions = [pose], True
        path = self.call("compute_cartesian_path", request)
        print(f"> straight {path.fraction:.2f}")
        goal = ExecuteTrajectory.Goal(trajectory=path.solution)
        print("> lowered", self.result(self.executor_of_plans, goal).error_code.val)
        print(f"> at {self.where().position.z:.3f}")

    def where(self) -> Pose:
        request = GetPositionFK.Request(fk_link_names=[TIP])
        request.robot_state.is_diff = True
        return self.call("compute_fk", request).pose_stamped[0].pose

    def solutions(self):
        request = GetPositionIK.Request()
        request.ik_request.group_name = "panda_arm"
        request.ik_request.robot_state.is_diff = True
        request.ik_request.pose_stamped.header.frame_id = "panda_link0"
        request.ik_request.pose_stamped.pose = self.where()
        solved = self.call("compute_ik", request)
        print("> solved", solved.error_code.val)
        request.ik_request.pose_stamped.pose.position.x = 9.0
        print("> out of reach", self.call("compute_ik", request).error_code.val)
        request = GetMotionPlan.Request(motion_plan_request=self.request(ASIDE).request)
        answer = self.call("plan_kinematic_path", request)
        print("> a plan alone", answer.motion_plan_response.error_code.val)

    def wall(self):
        wall = CollisionObject(id="wall", operation=CollisionObject.ADD)
        wall.header.frame_id = "panda_link0"
        wall.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.1, 0.1, 0.1])]
        wall.primitive_poses = [Pose()]
        wall.primitive_poses[0].position.x = -0.5
        scene = PlanningScene(is_diff=True)
        scene.robot_state.is_diff = True
        scene.world.collision_objects = [wall]
        applied = self.call("apply_planning_scene", ApplyPlanningScene.Request(scene=scene))
        request = GetPlanningScene.Request()
        request.components.components = request.components.WORLD_OBJECT_NAMES
        there = self.call("get_planning_scene", request)
        names = [item.id for item in there.scene.world.collision_objects]
        print("> scene", applied.success, names)


def main():
    rclpy.init()
    cell = Cell()
    cell.wall()
    cell.aside()
    cell.back()
    cell.lower()
    cell.solutions()


if __name__ == "__main__":
    main()
