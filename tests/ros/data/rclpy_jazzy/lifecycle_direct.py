import rclpy
from rclpy.lifecycle import LifecycleNode, Node, State, TransitionCallbackReturn
from std_msgs.msg import String


class Careful(Node):
    def on_configure(self, state):
        raise RuntimeError("no driver")

    def on_error(self, state):
        print("on_error", state.label)
        return TransitionCallbackReturn.SUCCESS


rclpy.init()
careful = Careful("careful")
print(careful.trigger_configure().name)
print(careful.trigger_shutdown().name)
plain = LifecycleNode("plain")
publisher = plain.create_lifecycle_publisher(String, "out", 1)
print(publisher.is_activated, plain.trigger_configure().name, plain.trigger_activate().name, publisher.is_activated)
publisher.publish(String(data="x"))
print(plain.trigger_deactivate().name, publisher.is_activated)
publisher.publish(String(data="dropped"))
print(plain.trigger_cleanup().name, plain.trigger_shutdown().name)
try:
    print(plain.trigger_configure())
except Exception as error:
    print(type(error).__name__)
broken = LifecycleNode("broken", enable_communication_interface=False)
print([name for name, _ in broken.get_service_names_and_types_by_node("broken", "/") if "state" in name])
print(State("a", 1), list(TransitionCallbackReturn.__members__))
