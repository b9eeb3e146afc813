import rclpy
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
rclpy.init()
node = LifecycleNode("life")
for name in ("activate", "configure", "configure", "cleanup", "deactivate", "configure", "activate",
             "cleanup", "deactivate", "shutdown", "shutdown", "activate"):
    try:
        print(name, getattr(node, "trigger_" + name)().name, node._state_machine.current_state)
    except Exception as error:
        print(name, type(error).__name__, str(error).split(":")[0], node._state_machine.current_state)
