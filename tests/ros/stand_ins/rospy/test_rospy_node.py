"""rospy: the node's life, time, parameters, names and log, as its sources and wiki document.

Sources: ros/ros_comm `clients/rospy/src/rospy/{client,core,timer,rostime,names}.py`, and the wiki
pages rospy/Overview/{Initialization and Shutdown,Time,Parameter Server,Logging}.
The stand-in is imported inside each program, for it exists only there.
"""

import sys
import time

import pytest

from tracerisk.ros.time.scheduler import RunOver

SECOND = 1_000_000_000

# The names of `__all__` and of the imports of rospy/__init__.py in ros_comm noetic.
PUBLIC_NAMES = """
Header spin myargv init_node get_master get_published_topics wait_for_service on_shutdown
get_param get_param_cached get_param_names set_param delete_param has_param search_param sleep
Rate Timer DEBUG INFO WARN ERROR FATAL is_shutdown signal_shutdown get_node_uri get_ros_root
logout parse_rosrpc_uri MasterProxy ROSException ROSSerializationException ROSInitException
ROSInterruptException ROSTimeMovedBackwardsException ROSInternalException TransportException
TransportTerminated TransportInitError AnyMsg Message get_name get_caller_id get_namespace
resolve_name remap_name Time Duration get_rostime get_time ServiceException Service ServiceProxy
SubscribeListener Publisher Subscriber wait_for_message
"""


def test_time_cannot_be_asked_for_before_the_node_is_initialized(run_node):
    def main():
        import rospy

        for ask in (rospy.Time.now, rospy.get_time, lambda: rospy.Rate(1)):
            with pytest.raises(rospy.ROSInitException):
                ask()
        with pytest.raises(rospy.ROSInitException):
            rospy.spin()

    run_node(main)


def test_a_program_may_sleep_before_the_node_is_initialized(run_node):
    def main():
        import rospy

        began = time.time()
        rospy.sleep(1.5)
        assert time.time() - began == pytest.approx(1.5, abs=0.01)

    run_node(main)


def test_init_node_twice_is_allowed_with_the_same_arguments_only(run_node):
    def main():
        import rospy

        rospy.init_node("arm")
        rospy.init_node("arm")
        with pytest.raises(rospy.ROSException, match="already been called"):
            rospy.init_node("other")

    run_node(main)


@pytest.mark.parametrize("name", ["", "a/b"])
def test_init_node_refuses_names_that_are_none(run_node, name):
    def main():
        import rospy

        with pytest.raises(ValueError, match="name"):
            rospy.init_node(name)

    run_node(main)


def test_an_anonymous_name_is_the_same_in_every_run(run_node):
    def main():
        import rospy

        rospy.init_node("arm", anonymous=True)
        return rospy.get_name()

    assert run_node(main) == "/arm_1_1767225600000"


def test_the_command_line_names_remaps_and_sets_parameters(run_node):
    def main():
        import rospy

        rospy.init_node("arm")
        return (
            rospy.get_name(),
            rospy.get_namespace(),
            rospy.resolve_name("topic"),
            rospy.resolve_name("~topic"),
            rospy.resolve_name("old"),
            rospy.remap_name("old"),
            rospy.remap_name("kept"),
            rospy.get_param("~rate"),
            rospy.get_param("~on"),
            rospy.get_param("~names"),
            rospy.myargv(),
        )

    arguments = ("--fast", "__name:=left", "__ns:=/cell", "old:=new", "_rate:=2.5")
    assert run_node(main, *arguments, "_on:=yes", "_names:=[a, b]") == (
        "/cell/left",
        "/cell/",
        "/cell/topic",
        "/cell/left/topic",
        "/cell/new",
        "/cell/new",
        "kept",
        2.5,
        True,
        ["a", "b"],
        ["controller.py", "--fast"],
    )


def test_rospy_sleep_takes_seconds_and_durations(run_node, scheduler):
    def main():
        import rospy

        rospy.init_node("arm")
        rospy.sleep(1.5)
        rospy.sleep(rospy.Duration(2, 500_000_000))
        rospy.sleep(-3)

    run_node(main)
    assert scheduler.now_ns == 4 * SECOND


def test_time_and_duration_are_rospys_own_and_compute(run_node):
    def main():
        import rospy

        rospy.init_node("arm")
        start = rospy.Time.now()
        rospy.sleep(2)
        passed = rospy.Time.now() - start
        assert isinstance(start, rospy.Time)
        assert isinstance(start + rospy.Duration(1), rospy.Time)
        assert rospy.get_time() == pytest.approx(rospy.Time.now().to_sec() - 0.001, abs=1e-6)
        assert rospy.Time.from_sec(1.5) == rospy.Time(1, 500_000_000)
        return passed.to_sec(), repr(start), start.secs

    assert run_node(main) == (2.0, "rospy.Time[1767225600000000000]", 1_767_225_600)


def test_a_rate_keeps_its_period_whatever_the_work_takes(run_node):
    # timer.py: the next wake-up is the last one plus the period, not now plus the period.
    def main():
        import rospy

        rospy.init_node("arm")
        rate, woken = rospy.Rate(10), []
        for work in (0.0, 0.03, 0.09, 0.05):
            time.sleep(work)
            rate.sleep()
            woken.append(round(rospy.get_time() - 1_767_225_600, 3))
        return woken

    assert run_node(main) == [0.1, 0.2, 0.3, 0.4]


def test_a_rate_that_is_late_catches_up_until_it_is_late_by_more_than_two_periods(run_node):
    def woken_after(work):
        import rospy

        rate, woken = rospy.Rate(10), []
        for duration in work:
            time.sleep(duration)
            rate.sleep()
            woken.append(round(rospy.get_time() - start, 2))
        return woken

    start = 0.0

    def main():
        nonlocal start
        import rospy

        rospy.init_node("arm")
        start = rospy.get_time()
        late_by_two = woken_after((0.25, 0, 0, 0))
        start = rospy.get_time()
        late_by_more = woken_after((0.35, 0, 0))
        return late_by_two, late_by_more

    late_by_two, late_by_more = run_node(main)
    # 0.25 s late: the sleeps of 0.1 and 0.2 do not wait, that of 0.3 is on time again.
    assert late_by_two == pytest.approx([0.25, 0.25, 0.3, 0.4], abs=0.011)
    # 0.35 s late: it starts anew from there.
    assert late_by_more == pytest.approx([0.35, 0.45, 0.55], abs=0.011)


def test_remaining_says_what_the_next_sleep_would_take(run_node):
    def main():
        import rospy

        rospy.init_node("arm")
        rate = rospy.Rate(2)
        rospy.sleep(0.2)
        return rate.remaining().to_sec()

    assert run_node(main) == pytest.approx(0.3)


def test_a_busy_wait_on_is_shutdown_sees_callbacks(run_node, scheduler):
    def main():
        import rospy

        rospy.init_node("arm")
        done = []
        rospy.Timer(rospy.Duration(0.05), lambda _: done.append(True), oneshot=True)
        while not rospy.is_shutdown() and not done:
            pass

    run_node(main)
    assert scheduler.now_ns == pytest.approx(0.05 * SECOND, abs=2e6)


def test_shutdown_wakes_a_sleep_of_simulated_time_with_an_interruption(run_node, scheduler):
    def main():
        import rospy

        rospy.set_param("/use_sim_time", True)
        rospy.init_node("arm")
        rospy.Timer(rospy.Duration(1), lambda _: rospy.signal_shutdown("enough"), oneshot=True)
        with pytest.raises(rospy.ROSInterruptException) as caught:
            rospy.sleep(10)
        assert isinstance(caught.value, rospy.ROSException)
        assert isinstance(caught.value, KeyboardInterrupt)
        return str(caught.value), rospy.is_shutdown()

    assert run_node(main) == ("ROS shutdown request", True)
    assert scheduler.now_ns == SECOND


def test_shutdown_ends_spin(run_node, scheduler):
    def main():
        import rospy

        rospy.init_node("arm")
        rospy.Timer(rospy.Duration(2), lambda _: rospy.signal_shutdown("enough"), oneshot=True)
        rospy.spin()
        return "after spin"

    assert run_node(main) == "after spin"
    assert scheduler.now_ns == 2 * SECOND


def test_spin_with_nothing_to_come_is_a_quiet_end(run_node):
    def main():
        import rospy

        rospy.init_node("arm")
        rospy.spin()

    with pytest.raises(RunOver) as over:
        run_node(main)
    assert over.value.cause == "quiescent"
    assert over.value.location.file == __file__


def test_shutdown_hooks_run_once_in_order_before_the_flag_is_set(run_node):
    log = []

    def main():
        import rospy

        rospy.init_node("arm")
        rospy.on_shutdown(lambda: log.append(("first", rospy.is_shutdown())))
        rospy.on_shutdown(lambda: log.append(("second", rospy.is_shutdown())))
        rospy.signal_shutdown("enough")
        rospy.signal_shutdown("again")
        log.append(("after", rospy.is_shutdown()))

    run_node(main)
    assert log == [("first", False), ("second", False), ("after", True)]


def test_hooks_run_when_the_program_simply_ends_and_may_still_sleep(run_node, scheduler):
    def main():
        import rospy

        rospy.init_node("arm")
        rospy.on_shutdown(lambda: rospy.sleep(2))

    run_node(main)
    assert scheduler.now_ns == 2 * SECOND


def test_hooks_run_after_the_programs_own_exit_functions_also_without_a_node(run_node):
    log = []

    def main():
        import atexit

        import rospy

        rospy.on_shutdown(lambda: log.append("hook"))
        atexit.register(log.append, "atexit")

    run_node(main)
    assert log == ["atexit", "hook"]


def test_a_hook_that_raises_does_not_stop_the_others(run_node, capsys):
    log = []

    def main():
        import rospy

        rospy.init_node("arm")
        rospy.on_shutdown(lambda: {}["missing"])
        rospy.on_shutdown(lambda: log.append("second"))

    run_node(main)
    assert log == ["second"]
    assert "KeyError: 'missing'" in capsys.readouterr().err


def test_a_timer_says_when_it_should_have_fired_and_when_it_did(run_node):
    events = []

    def main():
        import rospy

        def fire(event):
            events.append(event)
            rospy.sleep(0.2)

        rospy.init_node("arm")
        timer = rospy.Timer(rospy.Duration(1), fire)
        rospy.sleep(3.5)
        timer.shutdown()
        rospy.sleep(3)

    run_node(main)
    start = 1_767_225_600
    assert [event.current_expected.to_sec() - start for event in events] == [1, 2, 3]
    assert [event.current_real.to_sec() - start for event in events] == [1, 2, 3]
    assert events[0].last_real is None
    assert events[1].last_expected == events[0].current_expected
    assert events[1].last_duration == pytest.approx(0.2)


def test_a_timer_whose_callback_raises_is_dead(run_node, monkeypatch):
    import threading

    monkeypatch.setattr(threading, "excepthook", lambda _: None)
    fired = []

    def main():
        import rospy

        def fire(event):
            fired.append(event)
            raise RuntimeError

        rospy.init_node("arm")
        timer = rospy.Timer(rospy.Duration(1), fire)
        rospy.sleep(5)
        return timer.is_alive()

    assert run_node(main) is False
    assert len(fired) == 1


def test_parameters(run_node):
    def main():
        import rospy

        with pytest.raises(KeyError):
            rospy.get_param("/missing")
        rospy.set_param("/arm", {"speed": 0.5, "limits": {"low": -1}})
        rospy.init_node("node")
        rospy.set_param("~own", [1, 2])
        assert rospy.get_param("/missing", "default") == "default"
        assert rospy.get_param("/missing", None) is None
        assert rospy.get_param("/arm/limits/low") == -1
        assert rospy.has_param("/arm/speed")
        assert rospy.search_param("speed") is None
        rospy.set_param("/speed", 1)
        assert rospy.search_param("speed") == "/speed"
        rospy.delete_param("/arm/limits")
        with pytest.raises(KeyError):
            rospy.delete_param("/arm/limits")
        return rospy.get_param_names()

    assert run_node(main) == ["/arm/speed", "/node/own", "/speed"]


def test_a_busy_wait_for_a_parameter_ends(run_node):
    def main():
        import rospy

        rospy.init_node("arm")
        rospy.Timer(rospy.Duration(0.05), lambda _: rospy.set_param("/go", 1), oneshot=True)
        while not rospy.has_param("/go"):
            pass
        while rospy.get_param("/go", None) is None:
            pass

    run_node(main)


def test_log_lines_go_to_standard_error_in_a_form_that_no_run_changes(run_node, capsys):
    def main():
        import rospy

        rospy.init_node("arm")
        rospy.logdebug("not shown")
        rospy.loginfo("moved %d of %s", 3, "ten")
        rospy.logwarn("%(what)s", {"what": "slow"})
        rospy.logerr(ValueError("bad"))
        rospy.logfatal("written wrongly %d", "x")
        rospy.loginfo("100 %")

    run_node(main)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.splitlines() == [
        "[INFO] moved 3 of ten",
        "[WARN] slow",
        "[ERROR] bad",
        "[FATAL] written wrongly %d ('x',)",
        "[INFO] 100 %",
    ]


def test_the_log_level_of_init_node_holds(run_node, capsys):
    def main():
        import rospy

        rospy.init_node("arm", log_level=rospy.DEBUG)
        rospy.logdebug("shown")

    run_node(main)
    assert capsys.readouterr().err == "[DEBUG] shown\n"


def test_once_throttled_and_identical_lines(run_node, capsys):
    def main():
        import rospy

        rospy.init_node("arm")
        for number in range(6):
            rospy.loginfo_once("once")
            rospy.loginfo_throttle(2, f"throttled {number}")
            rospy.logwarn_throttle_identical(100, f"identical {number // 3}")
            rospy.sleep(0.9)

    run_node(main)
    assert capsys.readouterr().err.splitlines() == [
        "[INFO] once",
        "[INFO] throttled 0",
        "[WARN] identical 0",
        "[INFO] throttled 3",
        "[WARN] identical 1",
    ]


def test_a_name_that_rospy_lacks_is_an_error_that_names_the_nearest(run_node):
    def main():
        import rospy

        with pytest.raises(AttributeError, match=r"rospy has no 'login'.*loginfo"):
            rospy.login("x")

    run_node(main)


def test_every_public_name_of_the_real_library_is_there(run_node):
    plain = PUBLIC_NAMES.split()
    logs = [
        f"log{level}{form}"
        for level in ("debug", "info", "warn", "err", "fatal")
        for form in ("", "_once", "_throttle", "_throttle_identical")
    ]

    def main():
        import rospy
        import rospy.client
        import rospy.core
        import rospy.exceptions
        import rospy.msg
        import rospy.names
        import rospy.numpy_msg
        import rospy.rostime
        import rospy.service
        import rospy.timer
        import rospy.topics
        from rospy.impl.tcpros_service import ServiceProxy

        assert ServiceProxy is rospy.ServiceProxy
        return [name for name in plain + logs if not hasattr(rospy, name)]

    assert run_node(main) == []


def test_the_node_of_one_run_is_unknown_to_the_next(run_node, scheduler, graph):
    from tracerisk.ros.graph.graph import Graph
    from tracerisk.ros.graph.runtime import Runtime, activate
    from tracerisk.ros.imports.finder import StandInFinder
    from tracerisk.ros.time.scheduler import Scheduler

    def main():
        import rospy

        was_initialized = rospy.core.is_initialized()
        rospy.init_node("arm")
        return was_initialized

    assert run_node(main) is False
    again = Scheduler(type(scheduler.world)(), duration_ns=SECOND)
    with activate(Runtime(again, Graph(again))), StandInFinder():
        assert again.run_main(main) is False
    assert "rospy" not in sys.modules
