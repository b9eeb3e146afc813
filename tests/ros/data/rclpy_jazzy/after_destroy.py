"""What still works when a node is destroyed."""
import rclpy
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.duration import Duration
from control_msgs.action import GripperCommand
from std_msgs.msg import Int32
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node("n")
publisher = node.create_publisher(Int32, "x", 1)
subscription = node.create_subscription(Int32, "x", lambda m: None, 1)
client = node.create_client(Trigger, "s")
service = node.create_service(Trigger, "s", lambda q, r: r)
timer = node.create_timer(1.0, lambda: None)
action = ActionClient(node, GripperCommand, "a")
guard = node.create_guard_condition(lambda: None)
executor = SingleThreadedExecutor()
executor.add_node(node)
rate = node.create_rate(10)
node.declare_parameter("p", 1)
node.destroy_node()


def tried(name, call):
    try:
        result = call()
        print(name, "->", type(result).__name__ if result is not None else None)
    except BaseException as error:
        print(name, "raises", type(error).__name__, str(error).split(", at ")[0])


tried("ok", rclpy.ok)
tried("publish", lambda: publisher.publish(Int32()))
tried("subscription_count", publisher.get_subscription_count)
tried("publisher_count", subscription.get_publisher_count)
tried("assert_liveliness", publisher.assert_liveliness)
tried("acked", lambda: publisher.wait_for_all_acked(Duration(seconds=0)))
tried("topic_name", lambda: publisher.topic_name)
tried("create_publisher", lambda: node.create_publisher(Int32, "y", 1))
tried("create_subscription", lambda: node.create_subscription(Int32, "y", lambda m: None, 1))
tried("create_client", lambda: node.create_client(Trigger, "t"))
tried("create_service", lambda: node.create_service(Trigger, "t", lambda q, r: r))
tried("create_timer", lambda: node.create_timer(1.0, lambda: None))
tried("create_rate", lambda: node.create_rate(1.0))
tried("create_guard", lambda: node.create_guard_condition(lambda: None))
tried("action_client", lambda: ActionClient(node, GripperCommand, "b"))
tried("call_async", lambda: client.call_async(Trigger.Request()))
tried("service_is_ready", client.service_is_ready)
tried("wait_for_service", lambda: client.wait_for_service(timeout_sec=0.3))
tried("send_goal_async", lambda: action.send_goal_async(GripperCommand.Goal()))
tried("server_is_ready", action.server_is_ready)
tried("wait_for_server", lambda: action.wait_for_server(timeout_sec=0.3))
tried("timer.cancel", timer.cancel)
tried("timer.reset", timer.reset)
tried("timer.is_ready", timer.is_ready)
tried("guard.trigger", guard.trigger)
tried("get_parameter", lambda: node.get_parameter("p"))
tried("declare_parameter", lambda: node.declare_parameter("q", 1))
tried("set_parameters", lambda: node.set_parameters([rclpy.Parameter("p", value=2)]))
tried("now", node.get_clock().now)
tried("log", lambda: node.get_logger().info("x"))
tried("get_name", node.get_name)
tried("topics", node.get_topic_names_and_types)
tried("services", node.get_service_names_and_types)
tried("node_names", node.get_node_names)
tried("count_publishers", lambda: node.count_publishers("x"))
tried("count_subscribers", lambda: node.count_subscribers("x"))
tried("executor.spin_once", lambda: executor.spin_once(timeout_sec=0.1))
tried("spin_once", lambda: rclpy.spin_once(node, timeout_sec=0.1))
tried("create_node", lambda: rclpy.create_node("m"))
