"""rclpy: nodes, names, parameters, quality of service, time, logging.

Sources: ros2/rclpy (branch jazzy) `rclpy/{node,parameter,qos,time,duration,clock}.py` and
`impl/rcutils_logger.py`; docs.ros.org "Passing ROS arguments to nodes via the command-line".
"""

import pytest


def test_a_node_needs_init_and_a_name_that_ros_takes(run_ros2):
    def main():
        import rclpy
        from rclpy.exceptions import (
            InvalidNamespaceException,
            InvalidNodeNameException,
            NotInitializedException,
        )

        with pytest.raises(NotInitializedException):
            rclpy.create_node("arm")
        rclpy.init()
        with pytest.raises(RuntimeError, match="must only be called once"):
            rclpy.init()
        for name in ("", "my-arm", "1st", "a/b"):
            with pytest.raises(InvalidNodeNameException):
                rclpy.create_node(name)
        with pytest.raises(InvalidNamespaceException):
            rclpy.create_node("arm", namespace="a b")
        node = rclpy.create_node("arm", namespace="left")
        return node.get_name(), node.get_namespace(), node.get_fully_qualified_name()

    assert run_ros2(main) == ("arm", "/left", "/left/arm")


def test_names_are_expanded_and_remapped(run_ros2):
    def main():
        import rclpy
        from rclpy.exceptions import InvalidServiceNameException, InvalidTopicNameException

        rclpy.init()
        node = rclpy.create_node("arm", namespace="/left")
        with pytest.raises(InvalidTopicNameException):
            node.resolve_topic_name("a b")
        with pytest.raises(InvalidServiceNameException):
            node.resolve_service_name("")
        names = [node.resolve_topic_name(name) for name in ("t", "/t", "~/t", "old", "{node}/x")]
        return node.get_name(), names

    arguments = ("--ros-args", "-r", "__node:=grip", "-r", "old:=/new", "--")
    assert run_ros2(main, *arguments) == (
        "grip",
        ["/left/t", "/t", "/left/grip/t", "/new", "/left/grip/x"],
    )


def test_parameters_are_declared_typed_and_overridden(run_ros2):
    def main():
        import rclpy
        from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
        from rclpy.exceptions import (
            InvalidParameterTypeException,
            InvalidParameterValueException,
            ParameterAlreadyDeclaredException,
            ParameterNotDeclaredException,
            ParameterUninitializedException,
        )
        from rclpy.parameter import Parameter

        rclpy.init()
        node = rclpy.create_node("arm")
        assert node.declare_parameter("speed", 1.0).value == 0.5
        assert node.declare_parameter("grip.force", 3).value == 3
        node.declare_parameters("joints", [("names", ["a"]), ("home", [0.0, 1.0])])
        with pytest.raises(ParameterAlreadyDeclaredException):
            node.declare_parameter("speed", 1.0)
        with pytest.raises(ParameterNotDeclaredException):
            node.get_parameter("nope")
        with pytest.raises(InvalidParameterTypeException, match="expecting type 'INTEGER'"):
            node.declare_parameter("count", 1)
        node.declare_parameter("late", Parameter.Type.DOUBLE_ARRAY)
        with pytest.raises(ParameterUninitializedException):
            node.get_parameter("late")
        limits = ParameterDescriptor(
            floating_point_range=[FloatingPointRange(from_value=0.0, to_value=1.0)]
        )
        with pytest.raises(InvalidParameterValueException, match="out of range"):
            node.declare_parameter("share", 2.0, limits)
        node.declare_parameter("share", 0.5, limits)
        refused = node.set_parameters([Parameter("share", value=1.5)])[0]
        wrong = node.set_parameters([Parameter("share", value="x")])[0]
        return (
            refused.successful,
            wrong.reason,
            node.get_parameter("speed").get_parameter_value().double_value,
            node.get_parameter_or("nope", Parameter("nope", value=1)).value,
            sorted(node.get_parameters_by_prefix("joints")),
            node.get_parameter("joints.home").value,
            node.has_parameter("use_sim_time"),
        )

    found = run_ros2(main, "--ros-args", "-p", "speed:=0.5", "-p", "arm:count:=many")
    assert found == (
        False,
        "Wrong parameter type, expected 'Type.DOUBLE' got 'Type.STRING'",
        0.5,
        1,
        ["home", "names"],
        [0.0, 1.0],
        True,
    )


def test_callbacks_agree_to_parameters_and_hear_of_them(run_ros2):
    def main():
        import rclpy
        from rcl_interfaces.msg import SetParametersResult
        from rclpy.parameter import Parameter

        rclpy.init()
        node = rclpy.create_node("arm")
        node.declare_parameter("speed", 1)
        reported = []

        def agree(parameters):
            return SetParametersResult(successful=parameters[0].value < 5, reason="too fast")

        node.add_on_set_parameters_callback(agree)
        node.add_post_set_parameters_callback(lambda ps: reported.extend(p.value for p in ps))
        results = node.set_parameters([Parameter("speed", value=v) for v in (2, 7)])
        return [r.successful for r in results], reported, node.get_parameter("speed").value

    assert run_ros2(main) == ([True, False], [2], 2)


def test_a_file_of_parameters_is_read(run_ros2, tmp_path):
    file = tmp_path / "arm.yaml"
    file.write_text(
        "/**:\n  ros__parameters:\n    speed: 1.5\narm:\n  ros__parameters:\n"
        "    grip: {force: 4, open: yes}\nother:\n  ros__parameters: {speed: 9.0}\n"
    )

    def main():
        import rclpy

        rclpy.init()
        node = rclpy.create_node("arm", automatically_declare_parameters_from_overrides=True)
        return [node.get_parameter(n).value for n in ("speed", "grip.force", "grip.open")]

    assert run_ros2(main, "--ros-args", "--params-file", str(file)) == [1.5, 4, True]


def test_late_comers_get_what_is_transient_local_if_they_ask(run_ros2):
    def main():
        import rclpy
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from std_msgs.msg import Int32

        rclpy.init()
        node = rclpy.create_node("arm")
        latching = QoSProfile(depth=2, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        publisher = node.create_publisher(Int32, "t", latching)
        for number in range(3):
            publisher.publish(Int32(data=number))
        late, plain = [], []
        node.create_subscription(Int32, "t", lambda m: late.append(m.data), latching)
        node.create_subscription(Int32, "t", lambda m: plain.append(m.data), 10)
        for _ in range(5):
            rclpy.spin_once(node, timeout_sec=0.0)
        return late, plain

    assert run_ros2(main) == ([1, 2], [])


def test_profiles_that_do_not_fit_pass_nothing_and_warn(run_ros2, capfd):
    def main():
        import rclpy
        from rclpy.qos import qos_profile_sensor_data
        from std_msgs.msg import Int32

        rclpy.init()
        node = rclpy.create_node("arm")
        seen = []
        node.create_subscription(Int32, "t", seen.append, 10)
        node.create_publisher(Int32, "t", qos_profile_sensor_data).publish(Int32())
        rclpy.spin_once(node, timeout_sec=0.1)
        return seen

    assert run_ros2(main) == []
    assert "offering incompatible QoS" in capfd.readouterr().err


def test_profiles_need_a_history_or_a_depth(run_ros2):
    def main():
        import rclpy
        from rclpy.qos import HistoryPolicy, InvalidQoSProfileException, QoSProfile
        from std_msgs.msg import Int32

        with pytest.raises(InvalidQoSProfileException):
            QoSProfile()
        with pytest.raises(InvalidQoSProfileException):
            QoSProfile(history=HistoryPolicy.KEEP_LAST)
        with pytest.raises(AssertionError):
            QoSProfile(depth=1.0)
        rclpy.init()
        node = rclpy.create_node("arm")
        with pytest.raises(ValueError, match="greater than or equal to zero"):
            node.create_publisher(Int32, "t", -1)
        with pytest.raises(TypeError, match="Expected QoSProfile or int"):
            node.create_publisher(Int32, "t", "10")
        return QoSProfile(depth=1) == QoSProfile(depth=1)

    assert run_ros2(main) is True


def test_publishing_checks_the_class(run_ros2):
    def main():
        import rclpy
        from std_msgs.msg import Int32, String

        rclpy.init()
        node = rclpy.create_node("arm")
        with pytest.raises(TypeError, match="Expected"):
            node.create_publisher(Int32, "t", 10).publish(String())

    run_ros2(main)


def test_times_and_durations_keep_their_kind(run_ros2):
    def main():
        from builtin_interfaces.msg import Duration as DurationMessage
        from rclpy.clock import Clock, ClockType, ROSClock
        from rclpy.duration import Duration
        from rclpy.time import Time

        assert Duration(seconds=1.5).to_msg() == DurationMessage(sec=1, nanosec=500_000_000)
        assert Duration.from_msg(Duration(seconds=-0.5).to_msg()) == Duration(
            nanoseconds=-5 * 10**8
        )
        one = Time(seconds=1, clock_type=ClockType.ROS_TIME)
        assert (one + Duration(seconds=1)) - one == Duration(seconds=1)
        with pytest.raises(TypeError, match="different clock types"):
            assert one < Time(seconds=2)
        with pytest.raises(ValueError, match="must not be negative"):
            Time(seconds=-1)
        assert isinstance(Clock(clock_type=ClockType.ROS_TIME), ROSClock)
        assert Time.from_msg(one.to_msg()) == one

    run_ros2(main)


def test_loggers_have_levels_children_and_filters(run_ros2, capfd):
    def main():
        import rclpy
        from rclpy.logging import LoggingSeverity, get_logger

        rclpy.init()
        log = rclpy.create_node("arm", namespace="left").get_logger()
        log.debug("hidden")
        log.get_child("grip").warning("shown")
        for number in range(3):
            log.info(f"once {number}", once=True)
            log.info(f"skipped {number}", skip_first=True)
            log.info(f"throttled {number}", throttle_duration_sec=10.0)
        log.set_level(LoggingSeverity.ERROR)
        log.info("hidden")
        get_logger("free").error("shown")
        with pytest.raises(TypeError):
            log.error("x", often=True)

    run_ros2(main)
    lines = capfd.readouterr().err.splitlines()
    assert [line.split("]: ")[1] for line in lines] == [
        "shown",
        "once 0",
        "throttled 0",
        "skipped 1",
        "skipped 2",
        "shown",
    ]
    assert lines[0].startswith("[WARN] [1767225600.")
    assert "[left.arm.grip]" in lines[0]


def test_waiting_for_a_message_needs_nothing_that_spins(run_ros2):
    def main():
        import threading

        import rclpy
        from rclpy.wait_for_message import wait_for_message
        from std_msgs.msg import String

        rclpy.init()
        node = rclpy.create_node("arm")
        publisher = node.create_publisher(String, "t", 10)
        threading.Timer(1.0, lambda: publisher.publish(String(data="x"))).start()
        came, message = wait_for_message(String, node, "t", time_to_wait=3.0)
        return came, message.data, wait_for_message(String, node, "t", time_to_wait=0.5)

    assert run_ros2(main) == (True, "x", (False, None))


def test_destroying_a_node_takes_its_endpoints_off_the_graph(run_ros2):
    def main():
        import rclpy
        from std_msgs.msg import String

        rclpy.init()
        node, other = rclpy.create_node("arm"), rclpy.create_node("other")
        node.create_publisher(String, "t", 10)
        node.create_subscription(String, "t", print, 10)
        before = (other.count_publishers("t"), other.count_subscribers("t"))
        names = dict(other.get_topic_names_and_types())
        node.destroy_node()
        after = (other.count_publishers("t"), other.count_subscribers("t"))
        return before, after, names["/t"], other.get_node_names()

    assert run_ros2(main) == ((1, 1), (0, 0), ["std_msgs/msg/String"], ["other"])


def test_a_name_that_the_stand_in_lacks_is_an_error_that_names_it(run_ros2):
    def main():
        import rclpy

        with pytest.raises(AttributeError, match=r"rclpy has no 'spinn'.*spin"):
            rclpy.spinn()
        with pytest.raises(ImportError, match=r"rclpy\.executors has no 'EventsExecutor'"):
            from rclpy.executors import EventsExecutor  # noqa: F401

    run_ros2(main)


def test_who_imports_nodes_has_the_executors_too(run_ros2):
    # rclpy/node.py imports rclpy.executors itself, so controllers use it with no import of theirs.
    def main():
        import rclpy
        from rclpy.node import Node

        return Node.__name__, rclpy.executors.MultiThreadedExecutor.__name__

    assert run_ros2(main) == ("Node", "MultiThreadedExecutor")
