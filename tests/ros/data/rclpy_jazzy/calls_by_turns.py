import rclpy, time
from std_msgs.msg import Int32
from std_srvs.srv import Trigger
rclpy.init()
node = rclpy.create_node("n")
node.create_service(Trigger, "s", lambda q, r: r)
client = node.create_client(Trigger, "s")
order = []
node.create_subscription(Int32, "x", lambda m: order.append(m.data), 10)
publisher = node.create_publisher(Int32, "x", 10)
client.wait_for_service()
time.sleep(0.3)
for n in range(2):
    future = client.call_async(Trigger.Request())
    future.add_done_callback(lambda f, n=n: order.append(f"done {n}"))
    rclpy.spin_until_future_complete(node, future)
    print("returned", n, order)
publisher.publish(Int32(data=7))
time.sleep(0.2)
for turn in range(14):
    rclpy.spin_once(node, timeout_sec=0.1)
    print(turn, order)
