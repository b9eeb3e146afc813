import rclpy
from control_msgs.action import GripperCommand
from rclpy.action import ActionClient, ActionServer
from rclpy.action.graph import get_action_names_and_types, get_action_client_names_and_types_by_node, get_action_server_names_and_types_by_node

rclpy.init()
node = rclpy.create_node("n", namespace="/cell")
server = ActionServer(node, GripperCommand, "grip", lambda handle: GripperCommand.Result())
client = ActionClient(node, GripperCommand, "grip")
client.wait_for_server()
print(get_action_names_and_types(node))
print(get_action_server_names_and_types_by_node(node, "n", "/cell"))
print(get_action_client_names_and_types_by_node(node, "n", "/cell"))
print(sorted(name for name, _ in node.get_topic_names_and_types() if "grip" in name))
print(sorted(name for name, _ in node.get_service_names_and_types() if "grip" in name))
for do in (
    lambda: ActionServer(node, GripperCommand, "grip", None),
    lambda: ActionServer(node, GripperCommand, "bad name", print),
    lambda: ActionClient(node, GripperCommand, "9grip"),
    lambda: ActionServer(node, GripperCommand, "h", print, goal_callback=3),
    lambda: server.register_execute_callback(None),
    lambda: server.register_goal_callback("x"),
    lambda: server.register_cancel_callback("x"),
):
    try:
        print(type(do()).__name__)
    except Exception as error:
        print(type(error).__name__)
client.destroy()
server.destroy()
nobody = ActionClient(node, GripperCommand, "nobody")
print(nobody.wait_for_server(timeout_sec=0.2), nobody.server_is_ready())
