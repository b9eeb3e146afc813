"""A service that asks another one in its handler, as in a tutorial on callback groups."""
import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger


class Cell(Node):
    def __init__(self):
        super().__init__("cell")
        inner, outer = MutuallyExclusiveCallbackGroup(), ReentrantCallbackGroup()
        self.create_service(SetBool, "grip", self.grip, callback_group=inner)
        self.create_service(Trigger, "pick", self.pick, callback_group=outer)
        self.client = self.create_client(SetBool, "grip", callback_group=outer)

    def grip(self, request, response):
        print("grip", request.data)
        response.success = request.data
        response.message = "closed" if request.data else "open"
        return response

    def pick(self, request, response):
        answer = self.client.call(SetBool.Request(data=True))
        print("asked", answer.message)
        response.success, response.message = answer.success, f"picked, {answer.message}"
        return response


rclpy.init()
cell = Cell()
user = rclpy.create_node("user")
client = user.create_client(Trigger, "pick")
executor = MultiThreadedExecutor(num_threads=4)
executor.add_node(cell)
executor.add_node(user)
print(client.wait_for_service(timeout_sec=2.0), client.service_is_ready())
future = client.call_async(Trigger.Request())
executor.spin_until_future_complete(future, timeout_sec=5.0)
print(future.done(), future.result())
executor.shutdown()
