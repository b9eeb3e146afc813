import rclpy
from control_msgs.action import GripperCommand as G
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
rclpy.init()
node = rclpy.create_node("n")
held = []
def execute(handle):
    handle.succeed()
    return G.Result()
def answer(request):
    return GoalResponse.REJECT if request.command.position > 1 else GoalResponse.ACCEPT
def wait(future):
    rclpy.spin_until_future_complete(node, future, timeout_sec=2.0)
    return future.result()
server = ActionServer(node, G, "a", execute, goal_callback=answer, handle_accepted_callback=held.append)
client = ActionClient(node, G, "a")
client.wait_for_server()
handle = wait(client.send_goal_async(G.Goal()))
answered = wait(handle.cancel_goal_async())
print("refused", answered.return_code, len(answered.goals_canceling))
held[0].execute()
result = wait(handle.get_result_async())
print("result", result.status)
answered = wait(handle.cancel_goal_async())
print("ended", answered.return_code, len(answered.goals_canceling))
goal = G.Goal()
goal.command.position = 2.0
handle = wait(client.send_goal_async(goal))
print("accepted", handle.accepted)
answered = wait(handle.cancel_goal_async())
print("rejected", answered.return_code, len(answered.goals_canceling))
server.register_cancel_callback(lambda handle: CancelResponse.ACCEPT)
handle = wait(client.send_goal_async(G.Goal()))
answered = wait(handle.cancel_goal_async())
print("taken", answered.return_code, len(answered.goals_canceling), held[-1].is_cancel_requested)
