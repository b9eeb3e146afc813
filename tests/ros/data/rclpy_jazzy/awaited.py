import rclpy
import threading
from control_msgs.action import GripperCommand
from rclpy.action import ActionClient, ActionServer
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger


class Cell(Node):
    """Sequences of an arm with callbacks that await."""

    def __init__(self, group):
        super().__init__("cell", enable_rosout=False)
        self.order = []
        self.create_service(SetBool, "suction", self.suction, callback_group=group)
        self.create_service(Trigger, "pick", self.pick, callback_group=group)
        self.valve = self.create_client(SetBool, "suction", callback_group=group)
        self.picker = self.create_client(Trigger, "pick", callback_group=group)
        self.server = ActionServer(self, GripperCommand, "grip", self.grip, callback_group=group)
        self.gripper = ActionClient(self, GripperCommand, "grip", callback_group=group)
        self.timer = self.create_timer(0.1, self.tick, callback_group=group)
        self.done = False

    def suction(self, request, response):
        self.order.append(f"suction {request.data}")
        response.success = True
        return response

    async def pick(self, request, response):
        self.order.append("pick begins")
        answer = await self.valve.call_async(SetBool.Request(data=True))
        self.order.append(f"pick goes on {answer.success}")
        response.message = "picked"
        return response

    async def grip(self, handle):
        self.order.append("grip begins")
        await self.valve.call_async(SetBool.Request(data=False))
        handle.succeed()
        return GripperCommand.Result(position=0.04)

    async def tick(self):
        self.timer.cancel()
        answer = await self.picker.call_async(Trigger.Request())
        self.order.append(answer.message)
        handle = await self.gripper.send_goal_async(GripperCommand.Goal())
        self.order.append(f"goal {handle.accepted}")
        result = await handle.get_result_async()
        self.order.append(f"result {result.status} {result.result.position}")
        self.done = True


rclpy.init()
for kind in (SingleThreadedExecutor, MultiThreadedExecutor):
    for words, group in (("reentrant", ReentrantCallbackGroup()), ("exclusive", MutuallyExclusiveCallbackGroup()), ("default", None)):
        cell = Cell(group)
        executor = kind()
        executor.add_node(cell)
        cell.valve.wait_for_service()
        for _ in range(60):
            executor.spin_once(timeout_sec=0.05)
            if cell.done:
                break
        print(kind.__name__, words, cell.done)
        print("  ", sorted(cell.order) if kind is MultiThreadedExecutor else cell.order)
        executor.shutdown()
        cell.destroy_node()


class Failing(Node):
    def __init__(self):
        super().__init__("failing")
        self.publisher = self.create_publisher(String, "said", 10)
        self.create_subscription(String, "said", self.hear, 10)
        self.heard = []

    async def hear(self, message):
        self.heard.append(message.data)
        raise RuntimeError(f"cannot {message.data}")


node = Failing()
node.publisher.publish(String(data="hold"))
try:
    for _ in range(5):
        rclpy.spin_once(node, timeout_sec=0.3)
    print("not raised", node.heard)
except RuntimeError as error:
    print("raised", error, node.heard)
node.destroy_node()


async def chain():
    node.order = ["chain"]
    first = await client.call_async(Trigger.Request())
    second = await client.call_async(Trigger.Request())
    return first.message + second.message


node = rclpy.create_node("chained")
node.create_service(Trigger, "answer", lambda request, response: setattr(response, "message", "yes ") or response)
client = node.create_client(Trigger, "answer")
client.wait_for_service()
executor = SingleThreadedExecutor()
executor.add_node(node)
task = executor.create_task(chain)
executor.spin_until_future_complete(task, timeout_sec=3.0)
print(task.done(), task.result())
node.destroy_node()
rclpy.shutdown()
