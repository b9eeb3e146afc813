import rclpy
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Int32
from std_srvs.srv import Trigger


class Server(Node):
    def __init__(self):
        super().__init__("gripper")
        self.create_service(Trigger, "close", self.close)

    def close(self, request, response):
        response.success, response.message = True, "closed"
        return response


class Picker(Node):
    """Asks the gripper from its callback and spins there, as beginners do."""

    def __init__(self, helper):
        super().__init__("picker")
        self.helper = helper
        self.client = (helper or self).create_client(Trigger, "close")
        self.timer = self.create_timer(0.1, self.tick)
        self.said = []
        self.ticks = 0

    def tick(self):
        self.ticks += 1
        if self.ticks == 1:
            future = self.client.call_async(Trigger.Request())
            try:
                rclpy.spin_until_future_complete(self.helper or self, future, timeout_sec=1.0)
            except Exception as error:
                self.said.append(f"{type(error).__name__}: {error}")
            self.said.append(future.result().message if future.done() else "not done")


rclpy.init()
for kind in (SingleThreadedExecutor, MultiThreadedExecutor):
    for own_helper in (False, True):
        helper = rclpy.create_node("helper") if own_helper else None
        server, picker = Server(), Picker(helper)
        serving = SingleThreadedExecutor()
        serving.add_node(server)
        import threading
        thread = threading.Thread(target=serving.spin, daemon=True)
        thread.start()
        picker.client.wait_for_service()
        executor = kind()
        executor.add_node(picker)
        for _ in range(8):
            executor.spin_once(timeout_sec=0.4)
        print(kind.__name__, own_helper, picker.said, picker.executor is executor,
              [node.get_name() for node in executor.get_nodes()], picker.ticks > 1)
        executor.shutdown()
        serving.shutdown()
        thread.join(2.0)
        for node in (server, picker, helper):
            if node:
                node.destroy_node()

node = rclpy.create_node("global")
got = []


def tick():
    if not got:
        got.append("in")
        try:
            rclpy.spin_once(node, timeout_sec=0.0)
        except Exception as error:
            got.append(f"{type(error).__name__}: {error}")
        got.append("out")


node.create_timer(0.1, tick)
for _ in range(3):
    rclpy.spin_once(node, timeout_sec=0.5)
print(got, node.executor is rclpy.get_global_executor())
node.destroy_node()
rclpy.shutdown()
