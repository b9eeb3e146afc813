import rclpy
from lifecycle_msgs.msg import State as StateMsg
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from std_msgs.msg import String


class Arm(LifecycleNode):
    def __init__(self):
        super().__init__("arm")
        self.tries = 0

    def on_configure(self, state):
        print("configure from", state.label, state.state_id)
        self.out = self.create_lifecycle_publisher(String, "state", 10)
        self.tries += 1
        return TransitionCallbackReturn.FAILURE if self.tries == 1 else TransitionCallbackReturn.SUCCESS

    def on_activate(self, state):
        print("activate", self.out.is_activated)
        return super().on_activate(state)

    def on_deactivate(self, state):
        print("deactivate", self.out.is_activated)
        return super().on_deactivate(state)

    def on_cleanup(self, state):
        print("cleanup", state.label)
        self.destroy_publisher(self.out)
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state):
        print("shutdown", state.label)
        return TransitionCallbackReturn.SUCCESS

    def on_error(self, state):
        print("error", state.label)
        return TransitionCallbackReturn.SUCCESS


rclpy.init()
arm, user = Arm(), rclpy.create_node("user")
executor = rclpy.executors.SingleThreadedExecutor()
executor.add_node(arm)
executor.add_node(user)
change = user.create_client(ChangeState, "arm/change_state")
state = user.create_client(GetState, "arm/get_state")
available = user.create_client(GetAvailableTransitions, "arm/get_available_transitions")
change.wait_for_service()
state.wait_for_service()
available.wait_for_service()


def ask(client, request):
    future = client.call_async(request)
    executor.spin_until_future_complete(future, timeout_sec=5.0)
    return future.result()


print(ask(state, GetState.Request()).current_state.label)
for label in ("configure", "configure", "activate", "deactivate", "cleanup", "shutdown"):
    request = ChangeState.Request()
    request.transition.label = label
    print(label, ask(change, request).success, ask(state, GetState.Request()).current_state.label)
    print([item.transition.label for item in ask(available, GetAvailableTransitions.Request()).available_transitions])
print(StateMsg.PRIMARY_STATE_FINALIZED)
