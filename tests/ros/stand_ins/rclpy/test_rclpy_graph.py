"""rclpy: what a node sees of the graph; messages as bytes; the life of a context.

Sources: ros2/rclpy (branch rolling, commit ba72a017) `rclpy/rclpy/{node,serialization,publisher,
subscription,__init__,clock}.py` and `rclpy/test/test_node.py`.
"""

import pytest


def test_a_node_says_who_is_at_a_topic_and_how(run_ros2):
    def main():
        import rclpy
        from rclpy.topic_endpoint_info import TopicEndpointTypeEnum
        from std_msgs.msg import String
        from std_srvs.srv import Trigger

        rclpy.init()
        left, right = rclpy.create_node("left", namespace="cell"), rclpy.create_node("right")
        left.create_publisher(String, "/talk", 3)
        right.create_subscription(String, "talk", print, rclpy.qos.qos_profile_sensor_data)
        right.create_service(Trigger, "go", lambda request, response: response)
        left.create_client(Trigger, "/go")
        (sender,) = right.get_publishers_info_by_topic("talk")
        (receiver,) = right.get_subscriptions_info_by_topic("talk")
        assert sender.endpoint_type is TopicEndpointTypeEnum.PUBLISHER
        return (
            (sender.node_namespace, sender.node_name, sender.topic_type, sender.qos_profile.depth),
            receiver.qos_profile.reliability is rclpy.qos.ReliabilityPolicy.BEST_EFFORT,
            right.get_fully_qualified_node_names(),
            right.get_publisher_names_and_types_by_node("left", "/cell"),
            right.get_subscriber_names_and_types_by_node("right", "/"),
            [
                n
                for n, _ in left.get_service_names_and_types_by_node("right", "/")
                if "/right/" not in n
            ],
            left.get_client_names_and_types_by_node("left", "/cell"),
            (left.count_clients("/go"), left.count_services("/go")),
            (left.wait_for_node("right", 0.5), left.wait_for_node("/nobody", 0.5)),
        )

    endpoint, best_effort, nodes, publishes, subscribes, serves, calls, counts, found = run_ros2(
        main
    )
    assert endpoint == ("/cell", "left", "std_msgs/msg/String", 3)
    assert best_effort
    assert nodes == ["/cell/left", "/right"]
    assert ("/talk", ["std_msgs/msg/String"]) in publishes
    assert subscribes == [("/talk", ["std_msgs/msg/String"])]
    assert serves == ["/go"]
    assert calls == [("/go", ["std_srvs/srv/Trigger"])]
    assert counts == (1, 1)
    assert found == (True, False)


def test_what_a_node_that_is_none_does_cannot_be_reported(run_ros2):
    def main():
        import rclpy
        from rclpy.node import NodeNameNonExistentError

        rclpy.init()
        with pytest.raises(NodeNameNonExistentError, match="'/nobody'"):
            rclpy.create_node("arm").get_publisher_names_and_types_by_node("nobody", "/")

    run_ros2(main)


def test_messages_are_published_received_and_kept_as_bytes(run_ros2):
    def main():
        import rclpy
        from rclpy._rclpy_pybind11 import RCLError
        from rclpy.serialization import deserialize_message, serialize_message
        from std_msgs.msg import Int32

        rclpy.init()
        node = rclpy.create_node("arm")
        heard = []
        node.create_subscription(Int32, "t", heard.append, 10, raw=True)
        node.create_subscription(Int32, "t", lambda message: heard.append(message.data), 10)
        publisher = node.create_publisher(Int32, "t", 10)
        publisher.publish(serialize_message(Int32(data=5)))
        rclpy.spin_once(node)
        rclpy.spin_once(node)
        with pytest.raises(RCLError, match="failed to deserialize"):
            deserialize_message(b"\x00\x01\x00\x00", Int32)
        with pytest.raises(AttributeError, match="ROS 1 message type"):
            deserialize_message(heard[0], int)
        return heard, deserialize_message(heard[0], Int32).data

    assert run_ros2(main) == ([b"\x00\x01\x00\x00\x05\x00\x00\x00", 5], 5)


def test_a_context_begins_and_ends_as_a_context_manager(run_ros2):
    def main():
        import rclpy
        from rclpy.signals import SignalHandlerOptions, get_current_signal_handlers_options

        assert rclpy.init() is None
        assert get_current_signal_handlers_options() is SignalHandlerOptions.ALL
        with rclpy.Context() as context:
            rclpy.create_node("arm", context=context)
        return rclpy.ok(), context.ok()

    assert run_ros2(main) == (True, False)


def test_after_jazzy_init_ends_with_its_block(run_ros2):
    def main():
        import rclpy

        from tracerisk.ros.graph.runtime import current

        current().distro.follows_jazzy = True
        with rclpy.init():
            rclpy.create_node("arm")
            began = rclpy.ok()
        ended = rclpy.ok()
        with rclpy.init():
            return began, ended, rclpy.ok()

    assert run_ros2(main) == (True, False, True)


@pytest.mark.parametrize("made", ["Context()", "executors.SingleThreadedExecutor()"])
def test_humble_has_no_with_blocks(run_ros2, made):
    def main():
        import rclpy
        from rclpy import executors

        rclpy.init()
        with (
            pytest.raises(AttributeError, match="__enter__"),
            eval(made, {"Context": rclpy.Context, "executors": executors}),
        ):
            pass

    run_ros2(main, distro="humble")


@pytest.mark.parametrize("distro", ["humble", "jazzy"])
def test_nodes_and_their_parts_stand_in_no_with_block(run_ros2, distro):
    def main():
        import rclpy
        from std_msgs.msg import Empty

        rclpy.init()
        node = rclpy.create_node("arm")
        publisher = node.create_publisher(Empty, "go", 1)
        for part in (node, publisher, node.create_timer(1.0, print)):
            with (
                pytest.raises((TypeError, AttributeError), match=r"context manager|__enter__"),
                part,
            ):
                pass

    run_ros2(main, distro=distro)


def test_jumps_of_a_clock_can_be_asked_for_and_never_come(run_ros2):
    def main():
        import time

        import rclpy
        from rclpy.clock import JumpThreshold
        from rclpy.duration import Duration

        rclpy.init()
        clock = rclpy.create_node("arm").get_clock()
        with pytest.raises(ValueError, match="min_forward must be a positive"):
            JumpThreshold(min_forward=Duration(seconds=-1), min_backward=None)
        threshold = JumpThreshold(min_forward=Duration(seconds=1), min_backward=None)
        with pytest.raises(ValueError, match="must be callable"):
            clock.create_jump_callback(threshold)
        jumps = []
        with clock.create_jump_callback(threshold, post_callback=jumps.append):
            time.sleep(5.0)
        return jumps

    assert run_ros2(main) == []


def test_policies_have_their_older_names_and_are_classes(run_ros2):
    def main():
        from rclpy import qos

        older = qos.QoSReliabilityPolicy.RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT
        assert older is qos.ReliabilityPolicy.BEST_EFFORT
        assert isinstance(older, qos.QoSReliabilityPolicy)
        assert "rmw_qos_policy_reliability_reliable" not in qos.ReliabilityPolicy.short_keys()
        assert qos.qos_policy_name_from_kind(16) == "RELIABILITY"
        profile = qos.QoSPresetProfiles.get_from_short_key("best_available")
        return profile.reliability is qos.ReliabilityPolicy.BEST_AVAILABLE

    assert run_ros2(main)
