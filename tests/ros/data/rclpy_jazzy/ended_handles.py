import rclpy
from control_msgs.action import GripperCommand
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.action.server import GoalEvent, ServerGoalHandle

rclpy.init()
node = rclpy.create_node("gripper")
handles = []
cancelled_by = []


def attempt(words, act):
    try:
        print(words, act())
    except Exception as error:
        print(words, type(error).__name__, str(error).split(", at ")[0])


def wait(future, seconds=2.0):
    rclpy.spin_until_future_complete(node, future, timeout_sec=seconds)
    return future.result() if future.done() else None


def execute(handle):
    handles.append(handle)
    print("   executing", handle.is_active, handle.is_cancel_requested, handle.status, type(handle.request).__name__)
    handle.succeed()
    print("   succeeded", handle.is_active, handle.status)
    return GripperCommand.Result(position=0.3)


server = ActionServer(node, GripperCommand, "grip", execute, cancel_callback=lambda handle: (cancelled_by.append(1), CancelResponse.ACCEPT)[1], result_timeout=1)
client = ActionClient(node, GripperCommand, "grip")
client.wait_for_server()
goal = GripperCommand.Goal()
goal.command.position = 0.25
mine = wait(client.send_goal_async(goal))
print("first", mine.accepted)
answer = wait(mine.get_result_async())
print(answer.status, answer.result.position)
again = wait(mine.get_result_async())
print("again", again.status, again.result.position)
ended = handles[0]
attempt("request", lambda: ended.request.command.position)
attempt("active", lambda: ended.is_active)
attempt("status", lambda: ended.status)
attempt("cancel requested", lambda: ended.is_cancel_requested)
attempt("succeed", ended.succeed)
attempt("abort", ended.abort)
attempt("canceled", ended.canceled)
attempt("feedback", lambda: ended.publish_feedback(GripperCommand.Feedback()))
answer = wait(mine.cancel_goal_async())
print("cancel", answer.return_code, len(answer.goals_canceling), cancelled_by)
print(mine == mine, len(list(mine.goal_id.uuid)))
attempt("feedback given a text", lambda: client.send_goal_async(goal, feedback_callback="x") and "taken")
attempt("events", lambda: (GoalEvent.SUCCEED.name, GoalEvent.ABORT.name, GoalEvent.CANCELED.name))
rclpy.shutdown()
