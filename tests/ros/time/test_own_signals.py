"""Signals that a program sends itself: its main thread handles them, as in CPython and in rospy.

What rospy does was printed by rospy 1.15.15; what rclpy does is in `test_rclpy_recorded.py`.
"""

import _thread
import os
import signal
import threading
import time

import pytest

SECOND = 1_000_000_000


def sends(number=signal.SIGINT, after_s=0.5, how=None):
    """Send the process a signal from another thread."""
    send = how or (lambda: os.kill(os.getpid(), number))

    def run():
        time.sleep(after_s)
        send()

    threading.Thread(target=run, daemon=True).start()


def test_a_handler_runs_in_the_main_thread_and_its_sleep_goes_on(run, scheduler):
    seen = []

    def main():
        def handle(number, frame):
            seen.append((number, threading.current_thread() is threading.main_thread()))

        before = signal.signal(signal.SIGUSR1, handle)
        sends(signal.SIGUSR1)
        time.sleep(2.0)
        return before is signal.SIG_DFL, signal.getsignal(signal.SIGUSR1) is handle

    assert run(main) == (True, True)
    assert seen == [(signal.SIGUSR1, True)]
    assert scheduler.now_ns == 2 * SECOND
    assert signal.getsignal(signal.SIGUSR1) is signal.SIG_DFL


@pytest.mark.parametrize(
    "how",
    [
        None,
        lambda: signal.raise_signal(signal.SIGINT),
        lambda: _thread.interrupt_main(),
    ],
)
def test_without_a_handler_an_interrupt_ends_the_wait_of_the_main_thread(run, scheduler, how):
    def main():
        sends(how=how)
        with pytest.raises(KeyboardInterrupt):
            threading.Event().wait(5.0)

    run(main)
    assert scheduler.now_ns == SECOND // 2


def test_the_main_thread_handles_its_own_signal_at_once(run):
    def main():
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        signal.raise_signal(signal.SIGTERM)

    run(main)


def test_only_the_main_thread_sets_handlers(run):
    errors = []

    def main():
        def other():
            with pytest.raises(ValueError, match="only works in main thread") as caught:
                signal.signal(signal.SIGINT, signal.SIG_IGN)
            errors.append(caught.value)

        thread = threading.Thread(target=other)
        thread.start()
        thread.join()
        with pytest.raises(TypeError, match=r"must be signal\.SIG_IGN"):
            signal.signal(signal.SIGINT, "no handler")
        with pytest.raises(ValueError, match="out of range"):
            signal.signal(4000, signal.SIG_IGN)
        with pytest.raises(OSError, match="Invalid argument"):
            signal.signal(signal.SIGKILL, signal.SIG_IGN)

    run(main)
    assert len(errors) == 1


def test_an_interrupt_shuts_a_node_of_ros_1_down_and_its_sleep_goes_on(run_node, scheduler):
    log = []

    def main():
        import rospy

        rospy.init_node("n")
        rospy.on_shutdown(lambda: log.append(("hook", scheduler.now_ns)))
        sends()
        rospy.sleep(3.0)
        log.append(("slept", scheduler.now_ns))
        rospy.spin()
        return rospy.is_shutdown()

    assert run_node(main)
    assert log == [("hook", SECOND // 2), ("slept", 3 * SECOND)]


def test_a_loop_of_ros_1_ends_after_an_interrupt(run_node):
    def main():
        import rospy

        handled = []
        signal.signal(signal.SIGINT, lambda number, _: handled.append(number))
        rospy.init_node("n")
        sends(after_s=0.55)
        rate, turns = rospy.Rate(10), 0
        while not rospy.is_shutdown():
            turns += 1
            rate.sleep()
        return turns, handled

    assert run_node(main) == (6, [signal.SIGINT])


def test_a_node_without_signals_is_interrupted_where_it_spins(run_node):
    def main():
        import rospy

        rospy.init_node("n", disable_signals=True)
        sends()
        rospy.spin()
        sends()
        with pytest.raises(KeyboardInterrupt):
            time.sleep(5.0)
        return rospy.is_shutdown()

    assert run_node(main)


def test_a_node_of_ros_1_is_made_in_the_main_thread(run_node):
    def main():
        import rospy

        errors = []

        def other():
            try:
                rospy.init_node("n")
            except ValueError as error:
                errors.append(str(error))

        thread = threading.Thread(target=other)
        thread.start()
        thread.join()
        return errors

    assert run_node(main) == ["signal only works in main thread of the main interpreter"]
