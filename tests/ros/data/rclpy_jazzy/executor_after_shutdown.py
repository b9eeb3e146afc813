import rclpy
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
rclpy.init()
for kind in (SingleThreadedExecutor, MultiThreadedExecutor):
    node = rclpy.create_node("n")
    executor = kind()
    executor.add_node(node)
    print(kind.__name__, executor.shutdown(), executor.shutdown(), node.executor is executor)
    for name, do in (
        ("spin_once", lambda: executor.spin_once(timeout_sec=0.1)),
        ("spin", executor.spin),
        ("wake", executor.wake),
        ("nodes", lambda: executor.get_nodes()),
        ("create_task", lambda: executor.create_task(print)),
        ("remove_node", lambda: executor.remove_node(node)),
        ("add_node", lambda: executor.add_node(node)),
        ("nodes", lambda: len(executor.get_nodes())),
        ("spin_once of rclpy", lambda: rclpy.spin_once(node, executor=executor, timeout_sec=0.1)),
    ):
        try:
            print(name, do())
        except Exception as error:
            print(name, type(error).__name__, error)
for number in (0, -1):
    try:
        MultiThreadedExecutor(number)
        print(number, "made")
    except Exception as error:
        print(number, type(error).__name__, error)
