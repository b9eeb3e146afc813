import rclpy
from rclpy.qos import qos_profile_system_default
from rclpy.service_introspection import ServiceIntrospectionState
from service_msgs.msg import ServiceEventInfo
from std_srvs.srv import SetBool

rclpy.init()
node, user = rclpy.create_node("server"), rclpy.create_node("user")


def answer(request, response):
    response.success, response.message = request.data, "done"
    return response


service = node.create_service(SetBool, "grip", answer)
client = user.create_client(SetBool, "grip")
events = []
KINDS = {
    ServiceEventInfo.REQUEST_SENT: "sent", ServiceEventInfo.REQUEST_RECEIVED: "received",
    ServiceEventInfo.RESPONSE_SENT: "answered", ServiceEventInfo.RESPONSE_RECEIVED: "got",
}
user.create_subscription(
    SetBool.Event, "grip/_service_event",
    lambda event: events.append((KINDS[event.info.event_type], event.info.sequence_number, [item.data for item in event.request], [item.message for item in event.response])), 20,
)
executor = rclpy.executors.SingleThreadedExecutor()
executor.add_node(node)
executor.add_node(user)


def call(data):
    client.wait_for_service()
    future = client.call_async(SetBool.Request(data=data))
    executor.spin_until_future_complete(future, timeout_sec=5.0)
    for _ in range(10):
        executor.spin_once(timeout_sec=0.05)
    print(future.result().message, sorted(events))
    events.clear()


call(True)
service.configure_introspection(node.get_clock(), qos_profile_system_default, ServiceIntrospectionState.METADATA)
client.configure_introspection(user.get_clock(), qos_profile_system_default, ServiceIntrospectionState.CONTENTS)
for _ in range(10):
    executor.spin_once(timeout_sec=0.05)
call(False)
service.configure_introspection(node.get_clock(), qos_profile_system_default, ServiceIntrospectionState.OFF)
call(True)
print([state.name for state in ServiceIntrospectionState.__members__.values()] if hasattr(ServiceIntrospectionState, "__members__") else None)
