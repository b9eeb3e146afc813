import time
import rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from action_msgs.msg import GoalStatus

rclpy.init()
node = rclpy.create_node("arm")
started = []


def execute(handle):
    started.append(handle)
    for step in range(100):
        if handle.is_cancel_requested:
            handle.canceled()
            print("cancelled", handle.status == GoalStatus.STATUS_CANCELED)
            return FollowJointTrajectory.Result(error_string="stopped")
        time.sleep(0.05)
    handle.succeed()
    return FollowJointTrajectory.Result()


server = ActionServer(
    node, FollowJointTrajectory, "follow", execute,
    goal_callback=lambda goal: GoalResponse.ACCEPT if goal.trajectory.joint_names else GoalResponse.REJECT,
    cancel_callback=lambda handle: CancelResponse.ACCEPT,
    callback_group=ReentrantCallbackGroup(),
)
client = ActionClient(node, FollowJointTrajectory, "follow")
executor = MultiThreadedExecutor(4)
executor.add_node(node)


def wait(future):
    executor.spin_until_future_complete(future, timeout_sec=10.0)
    return future.result()


print(client.wait_for_server(timeout_sec=5.0))
handle = wait(client.send_goal_async(FollowJointTrajectory.Goal()))
print("empty", handle.accepted, handle.status)
goal = FollowJointTrajectory.Goal()
goal.trajectory.joint_names = ["a"]
handle = wait(client.send_goal_async(goal))
print("named", handle.accepted)
result = handle.get_result_async()
while not started:
    executor.spin_once(timeout_sec=0.1)
answer = wait(handle.cancel_goal_async())
print("cancel", answer.return_code, len(answer.goals_canceling), bytes(answer.goals_canceling[0].goal_id.uuid) == bytes(handle.goal_id.uuid))
answer = wait(result)
print("result", answer.status == GoalStatus.STATUS_CANCELED, answer.result.error_string)
answer = wait(handle.cancel_goal_async())
print("again", answer.return_code)
try:
    started[0].succeed()
except Exception as error:
    print(type(error).__name__)
executor.shutdown()
