"""rclpy: clocks that a topic or a program sets, their jumps, and what timers tell.

Sources: ros2/rclpy (branch rolling, commit ba72a017) `rclpy/rclpy/{clock,time_source,timer}.py`.
"""

from __future__ import annotations

import pytest


def test_a_time_source_sets_its_clocks_to_what_the_topic_says(run_ros2):
    def main():
        import rclpy
        from rclpy.clock import Clock, ClockType, ROSClock
        from rclpy.parameter import Parameter
        from rclpy.time_source import TimeSource
        from rosgraph_msgs.msg import Clock as ClockMessage

        rclpy.init()
        node = rclpy.create_node("arm")
        source, clock = TimeSource(node=node), ROSClock()
        source.attach_clock(clock)
        with pytest.raises(ValueError, match="ROS_TIME"):
            source.attach_clock(Clock(clock_type=ClockType.STEADY_TIME))
        before = clock.now().nanoseconds
        node.set_parameters([Parameter("use_sim_time", value=True)])
        at_first = clock.now().nanoseconds
        message = ClockMessage()
        message.clock.sec = 7
        node.create_publisher(ClockMessage, "/clock", 1).publish(message)
        rclpy.spin_once(node, timeout_sec=0.1)
        reported = clock.now().seconds_nanoseconds()
        node.set_parameters([Parameter("use_sim_time", value=False)])
        after = clock.now().nanoseconds
        refused = node.set_parameters([Parameter("use_sim_time", value=True)])[0].successful
        source.detach_node()
        return before > 10**18, at_first, reported, after > before, refused

    assert run_ros2(main) == (True, 0, (7, 0), True, True)


def test_jumps_are_reported_to_who_asked_for_them_before_and_after(run_ros2):
    def main():
        from rclpy.clock import ClockChange, JumpThreshold, ROSClock
        from rclpy.duration import Duration
        from rclpy.time import Time

        clock, reported = ROSClock(), []
        far = JumpThreshold(
            min_forward=Duration(seconds=2),
            min_backward=Duration(seconds=-1),
            on_clock_change=False,
        )
        change = JumpThreshold(min_forward=None, min_backward=None)
        clock.create_jump_callback(
            far,
            pre_callback=lambda: reported.append("before"),
            post_callback=lambda jump: reported.append(jump.delta.nanoseconds / 1e9),
        )
        with clock.create_jump_callback(
            change, post_callback=lambda jump: reported.append(jump.clock_change)
        ):
            clock._set_ros_time_is_active(True)
        clock._set_ros_time_is_active(False)
        clock._set_ros_time_is_active(True)
        for seconds in (5, 6, 4.5):
            clock.set_ros_time_override(Time(seconds=seconds))
        assert ClockChange.ROS_TIME_ACTIVATED in reported
        return reported[1:]

    assert run_ros2(main) == ["before", 5.0, "before", -1.5]


def test_a_sleep_of_a_clock_that_is_set_ends_when_it_is_set_further_or_left_alone(run_ros2):
    def main():
        import threading
        import time

        import rclpy
        from rclpy.clock import ROSClock
        from rclpy.duration import Duration
        from rclpy.time import Time

        rclpy.init()
        clock, slept = ROSClock(), []
        clock._set_ros_time_is_active(True)
        clock.set_ros_time_override(Time(seconds=1))
        for end in (
            lambda: clock.set_ros_time_override(Time(seconds=100)),
            lambda: clock._set_ros_time_is_active(False),
        ):
            thread = threading.Thread(
                target=lambda: slept.append(clock.sleep_for(Duration(seconds=10)))
            )
            thread.start()
            time.sleep(0.2)
            end()
            thread.join()
        began = clock.now()
        thread = threading.Thread(
            target=lambda: slept.append(clock.sleep_for(Duration(seconds=10)))
        )
        thread.start()
        time.sleep(0.2)
        clock._set_ros_time_is_active(True)
        thread.join()
        clock._set_ros_time_is_active(False)
        return slept, (clock.now() - began).nanoseconds < 10**9

    assert run_ros2(main) == ([True, False, False], True)


def test_a_timer_says_when_it_was_due_to_who_asks_for_it(run_ros2):
    def main():
        import rclpy
        from rclpy.timer import TimerInfo

        rclpy.init()
        node = rclpy.create_node("arm")
        reported = []

        def beat(info: TimerInfo):
            reported.append(info)

        node.create_timer(0.5, beat)
        rclpy.spin_once(node, timeout_sec=1.0)
        with pytest.raises(ValueError, match="negative"):
            TimerInfo(expected_call_time=-1)
        late = reported[0].actual_call_time - reported[0].expected_call_time
        return len(reported), late.nanoseconds

    assert run_ros2(main) == (1, 0)
