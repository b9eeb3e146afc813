"""rclpy: what lines pass, who hears of them, and who may change that.

Sources: ros2/rclpy (branch rolling, commit ba72a017)
`rclpy/rclpy/{logging,logging_service,impl/rcutils_logger}.py`.
"""

import pytest


def test_the_filters_are_asked_one_after_another(run_ros2):
    def main():
        import time

        import rclpy
        from rclpy.clock import ROSClock
        from rclpy.time import Time

        rclpy.init()
        log = rclpy.create_node("arm").get_logger()
        skipped, once, throttled = [], [], []
        clock = ROSClock()
        clock._set_ros_time_is_active(True)
        for number in range(5):
            skipped.append(log.info("s", skip_first=True, throttle_duration_sec=1.0))
            once.append(log.info("o", skip_first=True, once=True))
            throttled.append(
                log.info("t", throttle_duration_sec=2, throttle_time_source_type=clock)
            )
            clock.set_ros_time_override(Time(seconds=number + 1))
            time.sleep(0.4)
        return skipped, once, throttled

    skipped, once, throttled = run_ros2(main)
    assert skipped == [False, False, False, True, False]
    assert once == [False, True, False, False, False]
    assert throttled == [False, False, True, False, True]


def test_a_place_in_the_source_logs_with_one_severity_name_and_filter(run_ros2):
    def main():
        import rclpy
        from rclpy.logging import LoggingSeverity, get_logging_severity_from_string

        rclpy.init()
        log = rclpy.create_node("arm").get_logger()

        def say(severity, **keywords):
            log.log("line", severity, **keywords)

        def say_for(period):
            log.info("line", throttle_duration_sec=period)

        say(LoggingSeverity.INFO)
        for given, reported in (
            ({"severity": LoggingSeverity.WARN}, "severity cannot be changed"),
            ({"severity": LoggingSeverity.INFO, "name": "leg"}, "name cannot be changed"),
            ({"severity": LoggingSeverity.INFO, "once": True}, "filters cannot be changed"),
        ):
            with pytest.raises(ValueError, match=reported):
                say(**given)
        say_for(1.0)
        with pytest.raises(ValueError, match="parameters cannot be changed"):
            say_for(2.0)
        with pytest.raises(TypeError, match=r"required parameter .* not specified"):
            log.info("line", throttle_time_source_type=rclpy.clock.Clock())
        with pytest.raises(TypeError, match="not one of the recognized"):
            log.info("line", loudly=True)
        with pytest.raises(RuntimeError, match="no logging severity 'loud'"):
            get_logging_severity_from_string("loud")

    run_ros2(main)


@pytest.mark.parametrize(
    ("flag", "of_node", "heard"),
    [
        ("--enable-rosout-logs", True, 1),
        ("--enable-rosout-logs", False, 0),
        ("--disable-rosout-logs", True, 0),
    ],
)
def test_lines_are_published_unless_the_node_or_the_command_line_says_no(
    run_ros2, flag, of_node, heard
):
    def main():
        import rclpy
        from rcl_interfaces.msg import Log

        rclpy.init(args=["--ros-args", flag])
        node = rclpy.create_node("arm", enable_rosout=of_node)
        lines = []
        node.create_subscription(Log, "/rosout", lines.append, 10)
        node.get_logger().info("here")
        rclpy.spin_once(node, timeout_sec=0.1)
        return len(lines)

    assert run_ros2(main) == heard


def test_a_node_may_serve_the_levels_of_loggers(run_ros2):
    def main():
        import rclpy
        from rcl_interfaces.msg import LoggerLevel
        from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels

        rclpy.init()
        node = rclpy.create_node("arm", enable_logger_service=True)

        def called(kind, name, **request):
            client = node.create_client(kind, f"/arm/{name}")
            future = client.call_async(kind.Request(**request))
            rclpy.spin_until_future_complete(node, future)
            return future.result()

        results = called(
            SetLoggerLevels,
            "set_logger_levels",
            levels=[LoggerLevel(name="arm", level=10), LoggerLevel(name="leg", level=22)],
        ).results
        levels = called(GetLoggerLevels, "get_logger_levels", names=["arm", "leg"]).levels
        return [each.successful for each in results], [each.level for each in levels]

    assert run_ros2(main) == ([True, False], [10, 0])
