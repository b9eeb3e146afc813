"""Who gets what was published before: what is latched in ROS 1, transient local in ROS 2."""

import pytest

from tracerisk.ros.graph.runtime import current


@pytest.mark.parametrize("topic", ["/robot_description", "/tf_static_names", "/io/robot_mode"])
def test_of_what_the_twin_latched_a_volatile_subscription_gets_nothing(run_ros2, topic):
    def main():
        import rclpy
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from std_msgs.msg import String

        graph = current().graph
        twin = graph.advertise(
            topic, "std_msgs/String", node="/twin", latch=True, by_controller=False
        )
        twin.publish(String(data="old"))
        rclpy.init()
        node = rclpy.create_node("arm")
        late, plain = [], []
        latching = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(String, topic, lambda m: late.append(m.data), latching)
        node.create_subscription(String, topic, lambda m: plain.append(m.data), 1)
        for _ in range(4):
            rclpy.spin_once(node, timeout_sec=0.0)
        assert [each.need.name for each in graph.too_late()] == [topic]
        twin.publish(String(data="new"))
        for _ in range(4):
            rclpy.spin_once(node, timeout_sec=0.0)
        assert graph.too_late() == ()
        return late, plain

    assert run_ros2(main) == (["old", "new"], ["new"])


def test_what_the_controller_itself_latched_is_missed_in_the_same_way(run_ros2):
    def main():
        import rclpy
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from std_msgs.msg import String

        rclpy.init()
        node = rclpy.create_node("arm")
        latching = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_publisher(String, "recipe", latching).publish(String(data="a"))
        node.create_subscription(String, "recipe", print, 1)
        node.create_subscription(String, "other", print, 1)
        return [each.need.name for each in current().graph.too_late()]

    assert run_ros2(main) == ["/recipe"]


def test_in_ros_1_everybody_gets_what_is_latched(run_node):
    def main():
        import rospy
        from std_msgs.msg import String

        graph = current().graph
        twin = graph.advertise(
            "/description", "std_msgs/String", node="/twin", latch=True, by_controller=False
        )
        twin.publish(String(data="old"))
        rospy.init_node("arm")
        assert graph.too_late() == ()
        return rospy.wait_for_message("/description", String, timeout=1.0).data

    assert run_node(main) == "old"
