import rclpy
import threading
import time
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger


class Cell(Node):
    """Asks its vacuum gripper for suction from a timer, and waits there."""

    def __init__(self, name, timer_group, client_group):
        super().__init__(name)
        self.server = self.create_service(SetBool, f"{name}/suction", self.suction, callback_group=ReentrantCallbackGroup())
        self.client = self.create_client(SetBool, f"{name}/suction", callback_group=client_group)
        self.timer = self.create_timer(0.1, self.tick, callback_group=timer_group)
        self.said = None

    def suction(self, request, response):
        response.success, response.message = request.data, "on" if request.data else "off"
        return response

    def tick(self):
        self.timer.cancel()
        if not self.client.wait_for_service(timeout_sec=5.0):
            self.said = "no service"
            return
        future = self.client.call_async(SetBool.Request(data=True))
        heard = threading.Event()
        future.add_done_callback(lambda _: heard.set())
        if heard.wait(timeout=1.5):
            self.said = f"answered {future.result().success} {future.result().message}"
        else:
            self.said = f"no answer, done {future.done()}, cancelled {future.cancelled()}"
            self.client.remove_pending_request(future)


rclpy.init()
exclusive, reentrant = MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
shared, open_group = exclusive(), reentrant()
for name, timer_group, client_group in (
    ("default", None, None), ("shared", shared, shared), ("open", open_group, open_group),
    ("apart", exclusive(), exclusive()), ("half", None, exclusive()),
):
    cell = Cell(name, timer_group, client_group)
    executor = MultiThreadedExecutor(3)
    executor.add_node(cell)
    spinning = threading.Thread(target=executor.spin, daemon=True)
    spinning.start()
    for _ in range(60):
        time.sleep(0.1)
        if cell.said:
            break
    print(name, cell.said)
    executor.shutdown()
    spinning.join(2.0)
    cell.destroy_node()


class Synchronous(Node):
    """Calls and waits with `call` in a callback of another group."""

    def __init__(self):
        super().__init__("synchronous")
        self.create_service(Trigger, "home", self.home)
        self.client = self.create_client(Trigger, "home", callback_group=MutuallyExclusiveCallbackGroup())
        self.timer = self.create_timer(0.1, self.tick, callback_group=MutuallyExclusiveCallbackGroup())
        self.lines = []

    def home(self, request, response):
        response.success, response.message = True, "homed"
        return response

    def tick(self):
        answer = self.client.call(Trigger.Request())
        self.lines.append(answer.message)
        if len(self.lines) == 3:
            self.timer.cancel()


node = Synchronous()
executor = MultiThreadedExecutor()
executor.add_node(node)
while len(node.lines) < 3:
    executor.spin_once(timeout_sec=1.0)
print(node.lines, node.timer.is_canceled())
executor.shutdown()
node.destroy_node()
rclpy.shutdown()
