import rclpy
import time
from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint


class Arm(Node):
    """A driver that takes one goal, steps through it and hears of a cancel."""

    def __init__(self):
        super().__init__("arm")
        self.server = ActionServer(
            self, FollowJointTrajectory, "arm/follow_joint_trajectory", self.execute,
            goal_callback=self.judge, cancel_callback=lambda handle: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup())

    def judge(self, request):
        return GoalResponse.ACCEPT if request.trajectory.points else GoalResponse.REJECT

    def execute(self, handle):
        result = FollowJointTrajectory.Result()
        for number, point in enumerate(handle.request.trajectory.points):
            feedback = FollowJointTrajectory.Feedback()
            feedback.desired = point
            time.sleep(0.5)
            handle.publish_feedback(feedback)
            time.sleep(0.5)
            if handle.is_cancel_requested:
                result.error_string = f"stopped after {number}"
                handle.canceled()
                return result
        result.error_string = "there"
        handle.succeed()
        return result


class Mover(Node):
    def __init__(self, points, cancel_at):
        super().__init__("mover")
        self.points, self.cancel_at = points, cancel_at
        self.lines = []
        self.done = False
        self.client = ActionClient(self, FollowJointTrajectory, "arm/follow_joint_trajectory")

    def start(self):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = ["a"]
        for number in range(self.points):
            goal.trajectory.points.append(JointTrajectoryPoint(
                positions=[0.1 * number], time_from_start=Duration(sec=number + 1)))
        self.client.wait_for_server()
        self.sent = self.client.send_goal_async(goal, feedback_callback=self.feedback)
        self.sent.add_done_callback(self.answered)

    def answered(self, future):
        self.goal = future.result()
        self.lines.append(("accepted", self.goal.accepted))
        if not self.goal.accepted:
            self.lines.append(("status", self.goal.status))
            self.done = True
            return
        self.goal.get_result_async().add_done_callback(self.result)

    def feedback(self, message):
        feedback = message.feedback
        self.lines.append(("at", round(feedback.desired.positions[0], 1), feedback.desired.time_from_start.sec,
                           len(message.goal_id.uuid)))
        if feedback.desired.time_from_start.sec == self.cancel_at:
            self.goal.cancel_goal_async().add_done_callback(self.cancelled)

    def cancelled(self, future):
        answer = future.result()
        self.lines.append(("cancelling", len(answer.goals_canceling), answer.return_code == answer.ERROR_NONE))

    def result(self, future):
        answer = future.result()
        names = {GoalStatus.STATUS_SUCCEEDED: "succeeded", GoalStatus.STATUS_CANCELED: "cancelled"}
        self.lines.append(("result", names.get(answer.status, answer.status), answer.result.error_code,
                           answer.result.error_string, self.goal.status))
        self.done = True


rclpy.init()
for points, cancel_at in ((3, None), (4, 2), (0, None)):
    arm, mover = Arm(), Mover(points, cancel_at)
    executor = MultiThreadedExecutor(4)
    executor.add_node(arm)
    executor.add_node(mover)
    mover.start()
    while not mover.done:
        executor.spin_once(timeout_sec=1.0)
    print(points, cancel_at)
    for line in mover.lines:
        print("  ", *line)
    executor.shutdown()
    mover.destroy_node()
    arm.destroy_node()
rclpy.shutdown()
