import rclpy
import time
from rclpy.node import Node
from rclpy.parameter import Parameter

rclpy.init()
node = rclpy.create_node("arm", namespace="/left")
quiet = Node("quiet", parameter_overrides=[Parameter("start_type_description_service", value=False)])
bare = Node("bare", start_parameter_services=False, enable_rosout=False)
time.sleep(0.5)
for name, namespace in (("arm", "/left"), ("quiet", "/"), ("bare", "/")):
    for service, types in sorted(node.get_service_names_and_types_by_node(name, namespace)):
        print(service, types)
    print(node.get_publisher_names_and_types_by_node(name, namespace))
    print(node.get_subscriber_names_and_types_by_node(name, namespace), node.get_client_names_and_types_by_node(name, namespace))
print(len(node.get_service_names_and_types()))
print([service.srv_name for service in node.services], [service.srv_name for service in bare.services])
for each in (node, quiet, bare):
    print(each.get_name(), [(name, parameter.value) for name, parameter in sorted(each._parameters.items())])
try:
    node.get_service_names_and_types_by_node("nobody", "/")
except Exception as error:
    print(type(error).__name__)
rclpy.shutdown()
