import rclpy
from control_msgs.action import GripperCommand as G
from rclpy.action import ActionClient, ActionServer
rclpy.init()
node = rclpy.create_node("n")
order = []
def execute(handle):
    handle.publish_feedback(G.Feedback(position=0.5))
    handle.succeed()
    return G.Result()
ActionServer(node, G, "a", execute)
client = ActionClient(node, G, "a")
client.wait_for_server()
sent = client.send_goal_async(G.Goal(), feedback_callback=lambda m: order.append("feedback"))
sent.add_done_callback(lambda f: order.append("answered"))
rclpy.spin_until_future_complete(node, sent)
print("returned", sent.done(), order)
result = sent.result().get_result_async()
result.add_done_callback(lambda f: order.append("result"))
rclpy.spin_until_future_complete(node, result)
for turn in range(12):
    rclpy.spin_once(node, timeout_sec=0.1)
print(sorted(order))
