import threading
import rclpy
from std_srvs.srv import Trigger
rclpy.init()
node = rclpy.create_node("n")
client = node.create_client(Trigger, "absent")
threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
print(client.call(Trigger.Request(), timeout_sec=0.2))
print(client.call(Trigger.Request(), 0.1))
print(len(client._pending_requests) if hasattr(client, "_pending_requests") else 0)
rclpy.shutdown()
