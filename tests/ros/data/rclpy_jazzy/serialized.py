import rclpy
from rclpy.serialization import deserialize_message, serialize_message
from rosidl_runtime_py.utilities import get_message, get_service, get_action
from rosidl_runtime_py import message_to_ordereddict, message_to_yaml, set_message_fields
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from geometry_msgs.msg import PoseStamped

message = JointState(name=["a", "b"], position=[0.5, 1.5], velocity=[0.0, 1.0], effort=[2.0, 3.0])
message.header.frame_id = "base"
data = serialize_message(message)
print(type(data).__name__, len(data), data[:4].hex())
print(deserialize_message(data, JointState) == message)
print(get_message("std_msgs/msg/String") is String, get_service("std_srvs/srv/Trigger").__name__, get_action("control_msgs/action/GripperCommand").__name__)
print(dict(message_to_ordereddict(message)))
print(message_to_yaml(message))
pose = PoseStamped()
set_message_fields(pose, {"header": {"frame_id": "tool"}, "pose": {"position": {"x": 1.5}}})
print(pose.header.frame_id, pose.pose.position.x)
for do in (
    lambda: set_message_fields(pose, {"nothing": 1}),
    lambda: serialize_message("a"),
    lambda: get_message("std_msgs/msg/Nothing"),
    lambda: get_message("nothing"),
):
    try:
        print(do())
    except Exception as error:
        print(type(error).__name__)
rclpy.init()
node = rclpy.create_node("n")
raw = []
node.create_subscription(JointState, "raw", raw.append, 10, raw=True)
publisher = node.create_publisher(JointState, "raw", 10)
while publisher.get_subscription_count() == 0:
    rclpy.spin_once(node, timeout_sec=0.1)
publisher.publish(message)
publisher.publish(data)
for _ in range(10):
    rclpy.spin_once(node, timeout_sec=0.05)
print(len(raw), type(raw[0]).__name__, [deserialize_message(item, JointState) == message for item in raw])
