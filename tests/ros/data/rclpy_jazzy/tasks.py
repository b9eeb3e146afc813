import rclpy
from rclpy.executors import SingleThreadedExecutor
rclpy.init()
node = rclpy.create_node("n")
executor = SingleThreadedExecutor()
executor.add_node(node)
log = []
async def coroutine():
    log.append("run")
    return 5
task = executor.create_task(coroutine)
task.add_done_callback(lambda t: log.append(("done", t.result())))
executor.create_task(lambda: log.append("later"))
for turn in range(4):
    executor.spin_once(timeout_sec=0.05)
    print(turn, log)
def bad():
    raise ValueError("task")
executor.create_task(bad)
try:
    executor.spin_once(timeout_sec=0.05)
    print("no error")
except ValueError as error:
    print("raised", error)
def makes():
    log.append("makes")
    executor.create_task(lambda: log.append("made"))
executor.create_task(makes)
node.create_timer(0.0, lambda: log.append("tick")).cancel()
for turn in range(3):
    executor.spin_once(timeout_sec=0.05)
    print(turn, log[4:])
