"""Timers of `signal` under virtual time: their signal is not simulated (docs.python.org, signal)."""

import signal
import time

import pytest

from tracerisk.ros.time.scheduler import RunOver


def test_a_watchdog_that_is_cancelled_in_time_is_read_in_virtual_time(run, scheduler):
    def main():
        first = signal.alarm(10)
        time.sleep(2.5)
        left = signal.getitimer(signal.ITIMER_REAL)
        again = signal.setitimer(signal.ITIMER_REAL, 3.0, 1.0)
        at_end = signal.alarm(0)
        time.sleep(20)
        return first, left, again, at_end, signal.getitimer(signal.ITIMER_REAL)

    assert run(main) == (0, (7.5, 0.0), (7.5, 0.0), 3, (0.0, 0.0))
    assert scheduler.now_ns == 22_500_000_000


@pytest.mark.parametrize(
    ("set_timer", "expected"),
    [
        (lambda: signal.alarm(2), "the 2 s of signal.alarm are over"),
        (lambda: signal.setitimer(signal.ITIMER_PROF, 1.5), "the 1.5 s of signal.setitimer"),
    ],
)
def test_a_timer_that_is_due_ends_the_run_with_its_place(run, set_timer, expected):
    def main():
        set_timer()
        time.sleep(5)

    with pytest.raises(RunOver, match=expected) as over:
        run(main)
    assert over.value.cause == "raised"
    assert over.value.location.file == __file__


def test_bad_values_are_refused_as_by_the_real_ones(run):
    def main():
        for call in (
            lambda: signal.setitimer(signal.ITIMER_REAL, -1.0),
            lambda: signal.setitimer(99, 1.0),
            lambda: signal.getitimer(99),
        ):
            with pytest.raises(signal.ItimerError):
                call()
        with pytest.raises(TypeError):
            signal.alarm(1.5)

    run(main)


@pytest.mark.timeout(method="thread")  # the limit of a test is such a timer, too
def test_threads_of_others_have_the_real_timers(run):
    real = signal.getitimer
    run(lambda: None)
    assert signal.getitimer is real
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
