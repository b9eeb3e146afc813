import rclpy
from rclpy.task import Future, Task

rclpy.init()
node = rclpy.create_node("n")
executor = rclpy.get_global_executor()
executor.add_node(node)
future = Future()
print(future.done(), future.cancelled(), future.result(), future.exception())
future.add_done_callback(lambda done: print("callback", done.result()))
future.set_result(5)
print(future.done(), future.result())
future.add_done_callback(lambda done: print("late", done is future))
failed = Future()
failed.set_exception(ValueError("x"))
print(failed.done(), repr(failed.exception()))
try:
    failed.result()
except Exception as error:
    print(type(error).__name__, error)
gone = Future()
gone.cancel()
print(gone.cancelled(), gone.done(), gone.result())
gone.add_done_callback(lambda done: print("after cancel"))
bound = Future(executor=executor)
bound.add_done_callback(lambda done: print("in executor", done.result()))
bound.set_result("v")
print("before the spin")
rclpy.spin_once(node, executor=executor, timeout_sec=0.2)


async def wait_for(other):
    print("waits")
    value = await other
    return value + 1


late = Future()
task = executor.create_task(wait_for, late)
rclpy.spin_once(node, executor=executor, timeout_sec=0.1)
print(task.done())
late.set_result(1)
rclpy.spin_until_future_complete(node, task, executor, 2.0)
print(task.done(), task.result(), task.executing(), isinstance(task, Future))
direct = Task(lambda a, b=0: a + b, [1], {"b": 2})
direct()
print(direct.done(), direct.result())
direct()
try:
    Task(3)()
except Exception as error:
    print(type(error).__name__)
try:
    bad = Task(lambda: 1 / 0)
    bad()
    print(repr(bad.exception()))
except Exception as error:
    print("raised", type(error).__name__)
print(repr(Future())[:7], bool(Future()))
