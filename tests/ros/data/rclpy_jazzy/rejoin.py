import rclpy
from std_msgs.msg import Int32
rclpy.init()
old = rclpy.create_node("old")
publisher = old.create_publisher(Int32, "x", 1)
rclpy.shutdown()
rclpy.init()
print(rclpy.ok(), old.context.ok())
try:
    publisher.publish(Int32())
    print("published")
except Exception as error:
    print(type(error).__name__)
new = rclpy.create_node("new")
print(new.get_node_names())
seen = []
rclpy.get_default_context().on_shutdown(lambda: seen.append("on shutdown"))
rclpy.try_shutdown()
old.context.on_shutdown(lambda: seen.append("at once"))
print(seen, rclpy.ok())
