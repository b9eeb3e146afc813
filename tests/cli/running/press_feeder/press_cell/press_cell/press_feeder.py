"""Take parts from where the camera sees them, and lay them into a press."""

import rclpy
from control_msgs.action import FollowJointTrajectory, GripperCommand
from moveit_msgs.msg import MoveItErrorCodes
from moveit_msgs.srv import GetPositionIK
from rclpy.action import ActionClient
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from tf2_ros import Buffer, TransformException, TransformListener
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [
    "openarm_joint1",
    "openarm_joint2",
    "openarm_joint3",
    "openarm_joint4",
    "openarm_joint5",
    "openarm_joint6",
    "openarm_joint7",
]
HOME = [0.0, 0.3, 0.0, 1.2, 0.0, 0.6, 0.0]
PRESS = [0.8, 0.3, 0.0, 1.2, 0.0, 0.6, 0.0]
OPEN, CLOSED = 0.04, 0.0
PARTS = 1


class PressFeeder(Node):
    def __init__(self):
        super().__init__("press_feeder")
        group = ReentrantCallbackGroup()
        self.arm = ActionClient(
            self,
            FollowJointTrajectory,
            "joint_trajectory_controller/follow_joint_trajectory",
            callback_group=group,
        )
        self.hand = ActionClient(
            self, GripperCommand, "gripper_controller/gripper_cmd", callback_group=group
        )
        self.ik = self.create_client(GetPositionIK, "compute_ik", callback_group=group)
        self.frames = Buffer()
        self.listener = TransformListener(self.frames, self)
        self.pose = None
        self.fed = 0

    async def move(self, positions, seconds):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        point = JointTrajectoryPoint(positions=[float(each) for each in positions])
        point.time_from_start.sec = seconds
        goal.trajectory.points = [point]
        handle = await self.arm.send_goal_async(goal)
        result = await handle.get_result_async()
        return result.result.error_code == FollowJointTrajectory.Result.SUCCESSFUL

    async def grip(self, position):
        goal = GripperCommand.Goal()
        goal.command.position = position
        goal.command.max_effort = 20.0
        handle = await self.hand.send_goal_async(goal)
        await handle.get_result_async()

    async def joints_at(self, height):
        request = GetPositionIK.Request()
        request.ik_request.group_name = "arm"
        request.ik_request.pose_stamped.header.frame_id = "openarm_link0"
        request.ik_request.pose_stamped.pose.position.x = self.pose.translation.x
        request.ik_request.pose_stamped.pose.position.y = self.pose.translation.y
        request.ik_request.pose_stamped.pose.position.z = self.pose.translation.z + height
        request.ik_request.pose_stamped.pose.orientation = self.pose.rotation
        answer = await self.ik.call_async(request)
        if answer.error_code.val != MoveItErrorCodes.SUCCESS:
            return None
        state = answer.solution.joint_state
        return [state.position[state.name.index(name)] for name in JOINTS]

    async def locate(self):
        try:
            found = self.frames.lookup_transform("openarm_link0", "part", rclpy.time.Time())
        except TransformException as error:
            self.get_logger().error(str(error))
            return self.fault
        self.pose = found.transform
        return self.pick

    async def pick(self):
        above, at = await self.joints_at(0.08), await self.joints_at(0.0)
        if above is None or at is None:
            return self.fault
        await self.grip(OPEN)
        if not await self.move(above, 2) or not await self.move(at, 1):
            return self.fault
        await self.grip(CLOSED)
        return self.feed if await self.move(above, 1) else self.fault

    async def feed(self):
        if not await self.move(PRESS, 2):
            return self.fault
        await self.grip(OPEN)
        self.fed += 1
        return self.go_home

    async def go_home(self):
        await self.move(HOME, 2)
        return self.locate if self.fed < PARTS else None

    async def fault(self):
        self.get_logger().error("fault: going home")
        await self.move(HOME, 1)

    async def run(self):
        self.arm.wait_for_server()
        self.hand.wait_for_server()
        self.ik.wait_for_service()
        await self.move(HOME, 2)
        step = self.locate
        while step is not None:
            step = await step()


def main():
    rclpy.init()
    node = PressFeeder()
    executor = MultiThreadedExecutor()
    executor.add_node(node)
    executor.spin_until_future_complete(executor.create_task(node.run))
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
