import rclpy
from rclpy.node import Node
from std_msgs.msg import String


class Talker(Node):
    def __init__(self):
        super().__init__("talker")
        self.publisher = self.create_publisher(String, "chatter", 10)
        self.timer = self.create_timer(0.1, self.say)
        self.count = 0

    def say(self):
        self.publisher.publish(String(data=f"hello {self.count}"))
        self.count += 1


class Listener(Node):
    def __init__(self):
        super().__init__("listener")
        self.heard = []
        self.create_subscription(String, "chatter", self.hear, 10)

    def hear(self, message):
        self.heard.append(message.data)
        print("heard", message.data)
        if len(self.heard) == 3:
            raise SystemExit


rclpy.init()
listener = Listener()
talker = Talker()
executor = rclpy.executors.SingleThreadedExecutor()
executor.add_node(listener)
executor.add_node(talker)
while listener.count_publishers("chatter") == 0:
    executor.spin_once(timeout_sec=0.05)
try:
    executor.spin()
except SystemExit:
    print("done", talker.count >= 3, rclpy.ok())
executor.shutdown()
talker.destroy_node()
listener.destroy_node()
rclpy.shutdown()
print(rclpy.ok())
