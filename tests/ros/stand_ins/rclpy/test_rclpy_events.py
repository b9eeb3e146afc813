"""rclpy: events of publishers and subscriptions, and profiles that parameters change.

Sources: ros2/rclpy (branch rolling, commit ba72a017)
`rclpy/rclpy/{event_handler,qos_overriding_options,qos}.py`.
"""

import pytest


def test_both_sides_hear_who_comes_and_goes(run_ros2):
    def main():
        import rclpy
        from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
        from std_msgs.msg import Empty

        rclpy.init()
        node = rclpy.create_node("arm")
        heard = []

        def note(side):
            return lambda info: heard.append((side, info.current_count, info.current_count_change))

        publisher = node.create_publisher(
            Empty, "t", 1, event_callbacks=PublisherEventCallbacks(matched=note("publisher"))
        )
        subscription = node.create_subscription(
            Empty,
            "t",
            lambda _: None,
            1,
            event_callbacks=SubscriptionEventCallbacks(matched=note("subscription")),
        )
        for _ in range(2):
            rclpy.spin_once(node, timeout_sec=0.1)
        node.destroy_subscription(subscription)
        for _ in range(2):
            rclpy.spin_once(node, timeout_sec=0.1)
        return sorted(heard[:2]), heard[2:], publisher.get_subscription_count()

    assert run_ros2(main) == (
        [("publisher", 1, 1), ("subscription", 1, 1)],
        [("publisher", 0, -1)],
        0,
    )


def test_profiles_that_do_not_fit_are_reported_to_both_sides(run_ros2, capfd):
    def main():
        import rclpy
        from rclpy.event_handler import SubscriptionEventCallbacks
        from rclpy.qos import QoSPolicyKind, qos_profile_sensor_data
        from std_msgs.msg import Empty

        rclpy.init()
        node = rclpy.create_node("arm")
        reported = []
        node.create_subscription(
            Empty,
            "t",
            lambda _: None,
            1,
            event_callbacks=SubscriptionEventCallbacks(incompatible_qos=reported.append),
        )
        node.create_publisher(Empty, "t", qos_profile_sensor_data)
        for _ in range(2):
            rclpy.spin_once(node, timeout_sec=0.1)
        assert reported[0].last_policy_kind is QoSPolicyKind.RELIABILITY
        return len(reported), reported[0].total_count

    assert run_ros2(main) == (1, 1)
    assert "requesting incompatible QoS" in capfd.readouterr().err


def test_parameters_change_the_policies_that_an_endpoint_names(run_ros2):
    def main():
        import rclpy
        from rcl_interfaces.msg import SetParametersResult
        from rclpy.parameter import Parameter
        from rclpy.qos import ReliabilityPolicy
        from rclpy.qos_overriding_options import InvalidQosOverridesError, QoSOverridingOptions
        from std_msgs.msg import Empty

        rclpy.init()
        given = {
            "qos_overrides./t.publisher.reliability": "best_effort",
            "qos_overrides./t.publisher_left.depth": 7,
            "qos_overrides./u.subscription.history": "some",
        }
        node = rclpy.create_node(
            "arm", parameter_overrides=[Parameter(name, value=each) for name, each in given.items()]
        )
        options = QoSOverridingOptions.with_default_policies
        first = node.create_publisher(Empty, "t", 3, qos_overriding_options=options())
        left = node.create_publisher(
            Empty, "t", 3, qos_overriding_options=options(entity_id="left")
        )
        with pytest.raises(RuntimeError, match="Unexpected QoS override"):
            node.create_subscription(Empty, "u", print, 3, qos_overriding_options=options())
        with pytest.raises(InvalidQosOverridesError, match="too deep"):
            node.create_publisher(
                Empty,
                "v",
                3,
                qos_overriding_options=options(
                    callback=lambda _: SetParametersResult(successful=False, reason="too deep")
                ),
            )
        assert first.qos_profile.reliability is ReliabilityPolicy.BEST_EFFORT
        return first.qos_profile.depth, left.qos_profile.depth

    assert run_ros2(main) == (3, 7)


def test_a_profile_is_judged_warned_of_and_printed(run_ros2):
    def main():
        from rclpy.qos import (
            QoSCompatibility,
            QoSProfile,
            ReliabilityPolicy,
            qos_check_compatible,
            qos_profile_system_default,
        )
        from rclpy.topic_endpoint_info import TopicEndpointInfo
        from rclpy.type_hash import TypeHash

        with pytest.warns(UserWarning, match="zero depth"):
            QoSProfile(depth=0)
        wanted = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
        judged, why = qos_check_compatible(qos_profile_system_default, wanted)
        assert judged is QoSCompatibility.WARNING
        assert why.startswith("WARNING: Reliable subscription, but publisher is system_default;")
        text = str(TopicEndpointInfo("arm", qos_profile=QoSProfile(depth=4)))
        assert "Node name: arm" in text
        assert "History (Depth): KEEP_LAST (4)" in text
        assert "Topic type hash: INVALID" in text
        return str(TypeHash(1, bytes(31) + b"\x10"))

    assert run_ros2(main) == "RIHS01_" + "00" * 31 + "10"


def test_the_calls_of_a_service_are_published_as_far_as_each_end_says(run_ros2):
    def main():
        import rclpy
        from rclpy.qos import qos_profile_system_default
        from rclpy.service_introspection import ServiceIntrospectionState
        from std_srvs.srv import SetBool

        def serve(request, response):
            response.success = request.data
            return response

        rclpy.init()
        node = rclpy.create_node("arm")
        service, client = (
            node.create_service(SetBool, "on", serve),
            node.create_client(SetBool, "on"),
        )
        events = []
        node.create_subscription(SetBool.Event, "/on/_service_event", events.append, 10)

        def configure(end, state):
            end.configure_introspection(node.get_clock(), qos_profile_system_default, state)

        def called():
            future = client.call_async(SetBool.Request(data=True))
            rclpy.spin_until_future_complete(node, future)
            for _ in range(12):
                rclpy.spin_once(node, timeout_sec=0.01)
            reported = [
                (e.info.event_type, e.info.sequence_number, len(e.request), len(e.response))
                for e in events
            ]
            events.clear()
            return sorted(reported)

        configure(client, ServiceIntrospectionState.METADATA)
        configure(service, ServiceIntrospectionState.CONTENTS)
        both = called()
        configure(client, ServiceIntrospectionState.OFF)
        return both, called()

    both = [(0, 1, 0, 0), (1, 1, 1, 0), (2, 1, 0, 1), (3, 1, 0, 0)]
    assert run_ros2(main) == (both, [(1, 2, 1, 0), (2, 2, 0, 1)])
