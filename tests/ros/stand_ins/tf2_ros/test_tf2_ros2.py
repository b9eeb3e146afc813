"""tf2 as programs of ROS 2 use it: nothing is heard unless something spins."""

PROGRAM = """\
import rclpy, tf2_ros, tf2_geometry_msgs
from geometry_msgs.msg import PointStamped, TransformStamped
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.time import Time
from tf2_ros.buffer import Buffer
from tf2_ros.transform_listener import TransformListener

assert tf2_ros.TransformStamped is TransformStamped
rclpy.init()
node = Node("frames")
buffer = Buffer()
listener = TransformListener(buffer, node)
began = node.get_clock().now()
try:
    buffer.lookup_transform("panda_link0", "panda_hand", Time(), timeout=Duration(seconds=1.0))
    raise SystemExit("nobody spun")
except tf2_ros.TransformException as error:
    assert "does not exist" in str(error), error
assert 1.0 <= (node.get_clock().now() - began).nanoseconds / 1e9 < 1.1
static = tf2_ros.StaticTransformBroadcaster(node)
moving = tf2_ros.TransformBroadcaster(node)

def send(broadcaster, parent, child):
    t = TransformStamped()
    t.header.stamp = node.get_clock().now().to_msg()
    t.header.frame_id, t.child_frame_id = parent, child
    t.transform.translation.x = 0.25
    t.transform.rotation.w = 1.0
    broadcaster.sendTransform(t)

send(static, "panda_hand", "camera")
send(moving, "camera", "part")
end = node.get_clock().now() + Duration(seconds=0.5)
while node.get_clock().now() < end:
    rclpy.spin_once(node, timeout_sec=0.05)
found = buffer.lookup_transform("panda_hand", "part", Time())
assert abs(found.transform.translation.x - 0.5) < 1e-9, found
assert buffer.can_transform("world", "panda_hand_tcp", Time())
point = PointStamped()
point.header.frame_id = "part"
assert abs(buffer.transform(point, "panda_hand").point.x - 0.5) < 1e-9
future = buffer.wait_for_transform_async("world", "panda_hand", node.get_clock().now() + Duration(seconds=0.2))
rclpy.spin_until_future_complete(node, future, timeout_sec=2.0)
assert future.done() and future.result().child_frame_id == "panda_hand"
node.destroy_node()
rclpy.shutdown()
"""


def test_a_buffer_is_filled_while_the_node_is_spun(example):
    example.write("frames.py", PROGRAM)
    outcome = example.run("trace", "frames.py", "--robot", "panda")
    assert outcome.code == 0, outcome.err
