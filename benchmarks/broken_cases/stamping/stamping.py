"""Carry blanks from a chute to a stamp: states, services, tf and actions (ROS 2)."""

import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory, GripperCommand
from moveit_msgs.srv import GetPositionIK
from rclpy.action import ActionClient
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger
from tf2_ros import Buffer, TransformException, TransformListener
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"axis_{number}" for number in range(1, 7)]


class Stamping(Node):
    def __init__(self):
        super().__init__("stamping")
        group = ReentrantCallbackGroup()
        self.blanks = self.declare_parameter("blanks", 1).value
        self.rest_posture = self.declare_parameter("rest_posture", [0.0] * 6).value
        self.stamp_posture = self.declare_parameter("stamp_posture", [0.0] * 6).value
        self.arm = ActionClient(
            self, FollowJointTrajectory, "arm_controller/follow_joint_trajectory"
        )
        self.fingers = ActionClient(self, GripperCommand, "gripper_controller/gripper_cmd")
        self.solver = self.create_client(GetPositionIK, "compute_ik", callback_group=group)
        self.feeder = self.create_client(Trigger, "chute/next", callback_group=group)
        self.stamp = self.create_client(SetBool, "stamp/press", callback_group=group)
        self.buffer = Buffer()
        self.listener = TransformListener(self.buffer, self)
        self.pose = None
        self.done = 0

    async def drive(self, posture, seconds):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        point = JointTrajectoryPoint(positions=list(posture))
        point.time_from_start = Duration(sec=seconds)
        goal.trajectory.points.append(point)
        handle = await self.arm.send_goal_async(goal)
        if not handle.accepted:
            self.get_logger().error("the arm refused a goal")
            return False
        outcome = await handle.get_result_async()
        return outcome.result.error_code == FollowJointTrajectory.Result.SUCCESSFUL

    async def set_fingers(self, opening):
        goal = GripperCommand.Goal()
        goal.command.position = opening
        goal.command.max_effort = 15.0
        handle = await self.fingers.send_goal_async(goal)
        outcome = await handle.get_result_async()
        return outcome.result.reached_goal or outcome.result.stalled

    async def solve(self, above):
        request = GetPositionIK.Request()
        request.ik_request.group_name = "arm"
        request.ik_request.ik_link_name = "tip"
        request.ik_request.pose_stamped.header.frame_id = "base"
        pose = request.ik_request.pose_stamped.pose
        pose.position.x = self.pose.translation.x
        pose.position.y = self.pose.translation.y
        pose.position.z = self.pose.translation.z + above
        pose.orientation = self.pose.rotation
        answer = await self.solver.call_async(request)
        if answer.error_code.val != 1:
            self.get_logger().warning(f"no solution, {answer.error_code.val}")
            return None
        state = answer.solution.joint_state
        return [state.position[list(state.name).index(name)] for name in JOINTS]

    async def find(self):
        answer = await self.feeder.call_async(Trigger.Request())
        if not answer.success:
            return "end"
        try:
            lookup_transform = self.buffer.lookup_transform("base", "blank", rclpy.time.Time())
        except TransformException as error:
            self.get_logger().error(str(error))
            return "fail"
        self.pose = lookup_transform.transform
        return "take"

    async def take(self):
        above, at = await self.solve(0.08), await self.solve(0.0)
        if above is None or at is None:
            return "fail"
        await self.set_fingers(0.04)
        if not (await self.drive(above, 2) and await self.drive(at, 2)):
            return "fail"
        await self.set_fingers(0.01)
        return "bring" if await self.drive(above, 2) else "fail"

    async def bring(self):
        if not await self.drive(self.stamp_posture, 3):
            return "fail"
        await self.set_fingers(0.04)
        return "press"

    async def press(self):
        await self.drive(self.rest_posture, 3)
        await self.stamp.call_async(SetBool.Request(data=True))
        self.done += 1
        return "find" if self.done < self.blanks else "end"

    async def fail(self):
        self.get_logger().error("giving up")
        return "end"

    async def run(self):
        states = {"find": self.find, "take": self.take, "bring": self.bring}
        states.update(press=self.press, fail=self.fail)
        self.arm.wait_for_server()
        self.fingers.wait_for_server()
        for client in (self.solver, self.feeder, self.stamp):
            client.wait_for_service()
        await self.drive(self.rest_posture, 2)
        state = "find"
        while state != "end":
            state = await states[state]()


def main():
    rclpy.init()
    node = Stamping()
    executor = MultiThreadedExecutor()
    executor.add_node(node)
    task = executor.create_task(node.run)
    executor.spin_until_future_complete(task)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
