import rclpy
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.parameter_event_handler import ParameterEventHandler
from rclpy.parameter import parameter_value_to_python

rclpy.init()
node, user = rclpy.create_node("driver"), rclpy.create_node("user")
node.declare_parameter("speed", 0.5)
node.declare_parameter("joints", ["a", "b"])
node.declare_parameter("count", 3)
executor = rclpy.executors.SingleThreadedExecutor()
executor.add_node(node)
executor.add_node(user)
client = AsyncParameterClient(user, "driver")
print(client.wait_for_services(timeout_sec=5.0), client.services_are_ready())


def wait(future):
    executor.spin_until_future_complete(future, timeout_sec=5.0)
    return future.result()


seen = []
handler = ParameterEventHandler(user)
watch = handler.add_parameter_callback("speed", "driver", lambda parameter: seen.append((parameter.name, parameter.value.double_value)))
handler.add_parameter_event_callback(lambda event: seen.append((event.node, len(event.changed_parameters))))
for _ in range(20):
    executor.spin_once(timeout_sec=0.05)
names = wait(client.list_parameters()).result.names
print([name for name in names if name in ("speed", "joints", "count")])
print([parameter_value_to_python(value) for value in wait(client.get_parameters(["speed", "joints", "count", "none"])).values])
print([answer.successful for answer in wait(client.set_parameters([Parameter("speed", value=0.8), Parameter("count", value="x")])).results])
print(wait(client.set_parameters_atomically([Parameter("speed", value=0.9)])).result.successful)
print([described.type for described in wait(client.describe_parameters(["speed", "joints"])).descriptors])
print(list(wait(client.get_parameter_types(["speed", "joints", "count"])).types))
for _ in range(20):
    executor.spin_once(timeout_sec=0.05)
print(seen)
handler.remove_parameter_callback(watch)
print(node.get_parameter("speed").value)
