import rclpy
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger


class Asker(Node):
    def __init__(self):
        super().__init__("asker")
        self.client = self.create_client(Trigger, "answer")
        self.create_service(Trigger, "answer", self.answer)
        self.create_subscription(String, "question", self.asked, 10)
        self.done = rclpy.task.Future()

    async def answer(self, request, response):
        print("answering")
        response.success, response.message = True, "42"
        return response

    async def asked(self, message):
        print("asked", message.data)
        response = await self.client.call_async(Trigger.Request())
        print("got", response.message)
        again = await self.client.call_async(Trigger.Request())
        print("again", again.success)
        self.done.set_result(message.data)


rclpy.init()
node = Asker()
publisher = node.create_publisher(String, "question", 10)
node.client.wait_for_service()
while publisher.get_subscription_count() == 0:
    rclpy.spin_once(node, timeout_sec=0.1)
publisher.publish(String(data="what"))
rclpy.spin_until_future_complete(node, node.done, timeout_sec=5.0)
print(node.done.result())


async def work():
    first = await node.client.call_async(Trigger.Request())
    return first.message * 2


executor = rclpy.get_global_executor()
executor.add_node(node)
task = executor.create_task(work)
executor.spin_until_future_complete(task, timeout_sec=5.0)
print(task.result(), task.done(), task.cancelled())
try:
    node.client.call("no request")
except Exception as error:
    print(type(error).__name__)
try:
    node.client.call_async(Trigger.Response())
except Exception as error:
    print(type(error).__name__)
