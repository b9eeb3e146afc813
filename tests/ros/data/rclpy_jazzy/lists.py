import rclpy, time
from std_msgs.msg import Int32
rclpy.init()
node = rclpy.create_node("n")
node.create_publisher(Int32, "x", 1)
node.get_logger().info("x")
time.sleep(0.5)
print([name for name, _ in node.get_topic_names_and_types()])
print([name for name, _ in node.get_publisher_names_and_types_by_node("n", "/")])
print(node.count_publishers("/rosout"), node.get_node_names())
