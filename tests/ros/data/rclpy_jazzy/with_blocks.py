import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String


def attempt(words, act):
    try:
        print(words, act())
    except BaseException as error:
        print(words, type(error).__name__, error)


class Arm(Node):
    def __init__(self):
        super().__init__("arm")
        self.publisher = self.create_publisher(String, "said", 1)


def init_block():
    with rclpy.init() as made:
        assert rclpy.ok()
        node = Arm()
        return type(made).__name__, node.get_name(), rclpy.ok()


attempt("init", init_block)
print("after it", rclpy.ok())
rclpy.shutdown()


def context_block():
    with Context() as context:
        node = Node("own", context=context)
        inside = (context.ok(), rclpy.ok(), node.context is context)
    return inside, context.ok()


attempt("context", context_block)
rclpy.init()


def executor_block():
    with SingleThreadedExecutor() as executor:
        executor.add_node(Arm())
        inside = len(executor.get_nodes())
    return inside, len(executor.get_nodes())


attempt("executor", executor_block)


def external():
    node = Arm()
    node.create_timer(0.1, rclpy.shutdown)
    with MultiThreadedExecutor(2) as executor:
        executor.add_node(node)
        executor.spin()
    return rclpy.ok()


attempt("shut down in a callback", external)
rclpy.init()


def spun():
    node = Arm()
    node.create_timer(0.1, rclpy.shutdown)
    rclpy.spin(node)
    return "returned"


attempt("spin", spun)
attempt("shutdown again", rclpy.shutdown)
attempt("try_shutdown", rclpy.try_shutdown)
rclpy.init()
attempt("init again", rclpy.init)
rclpy.get_default_context().on_shutdown(lambda: print("told"))
rclpy.shutdown()
