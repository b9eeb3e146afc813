"""The scheduler by itself: the baton, the order of things, and how runs end."""

import contextlib
import sys

import pytest

from tracerisk.ros.time.scheduler import STREAM_PATIENCE_NS, RunOver, Scheduler

SECOND = 1_000_000_000
MS = 1_000_000


def here() -> int:
    return sys._getframe(1).f_lineno


def test_a_sleep_takes_simulated_time_and_moves_the_world(scheduler, world):
    scheduler.run_main(lambda: scheduler.sleep(10 * SECOND))
    assert scheduler.now_ns == 10 * SECOND
    assert world.time_ns == 10 * SECOND


def test_the_result_of_main_is_returned_and_its_exception_raised(scheduler):
    assert scheduler.run_main(lambda: 7) == 7
    with pytest.raises(KeyError):
        Scheduler(scheduler.world, duration_ns=SECOND).run_main(lambda: {}["missing"])


def test_the_first_reading_of_an_instant_is_free_and_each_further_one_costs_a_millisecond(
    scheduler,
):
    def main():
        return [scheduler.read_clock() for _ in range(4)]

    assert scheduler.run_main(main) == [0, MS, 2 * MS, 3 * MS]


def test_each_thread_has_its_own_first_reading(scheduler):
    seen = []

    def main():
        scheduler.spawn(lambda: seen.append(scheduler.read_clock()), "reader")
        seen.append(scheduler.read_clock())
        scheduler.sleep(0)

    scheduler.run_main(main)
    assert seen == [0, 0]


def test_threads_run_by_time_and_then_by_the_order_in_which_they_began_to_wait(scheduler):
    log = []

    def sleeper(name, duration_ns):
        scheduler.sleep(duration_ns)
        log.append(name)

    def main():
        for name, duration_ns in (("c", 3), ("a", 1), ("b1", 2), ("b2", 2)):
            scheduler.spawn(lambda n=name, d=duration_ns: sleeper(n, d * SECOND), name)
        scheduler.sleep(4 * SECOND)

    scheduler.run_main(main)
    assert log == ["a", "b1", "b2", "c"]


def test_events_run_before_threads_of_the_same_instant(scheduler):
    log = []

    def main():
        scheduler.call_at(SECOND, lambda: log.append("event"))
        scheduler.sleep(SECOND)
        log.append("thread")

    scheduler.run_main(main)
    assert log == ["event", "thread"]


def test_a_cancelled_event_does_not_run(scheduler):
    log = []

    def main():
        scheduler.call_at(SECOND, lambda: log.append("event")).cancel()
        scheduler.sleep(2 * SECOND)

    scheduler.run_main(main)
    assert log == []


def test_a_wait_ends_when_its_predicate_holds(scheduler):
    arrived = []

    def main():
        scheduler.call_at(SECOND, lambda: arrived.append(1))
        return scheduler.wait_until(lambda: bool(arrived), reason="an arrival")

    assert scheduler.run_main(main) is True
    assert scheduler.now_ns == SECOND


def test_a_wait_times_out_and_says_so(scheduler):
    def main():
        return scheduler.wait_until(lambda: False, timeout_ns=SECOND, reason="nothing")

    assert scheduler.run_main(main) is False
    assert scheduler.now_ns == SECOND


def test_the_end_of_a_motion_wakes_who_waits_for_it(scheduler, world):
    def main():
        world.move(1.5)
        scheduler.wait_until(lambda: not world.busy, reason="the motion")
        return scheduler.now_ns

    assert scheduler.run_main(main) == 1.5 * SECOND


def test_time_between_steps_of_the_world_is_exact(scheduler):
    def main():
        scheduler.sleep(1_500_000)
        scheduler.sleep(1)
        return scheduler.now_ns

    assert scheduler.run_main(main) == 1_500_001


def test_a_busy_wait_on_a_thread_ends(scheduler):
    done = []

    def worker():
        scheduler.sleep(20 * MS)
        done.append(True)

    def main():
        scheduler.spawn(worker, "worker")
        while not done:
            scheduler.touch()

    scheduler.run_main(main)
    assert 20 * MS <= scheduler.now_ns <= 21 * MS


def test_threads_that_hand_each_other_work_for_ever_let_time_pass(world):
    scheduler = Scheduler(world, duration_ns=20 * MS)
    turn = [0]

    def player(me):
        while True:
            scheduler.wait_until(lambda: turn[0] == me, reason="my turn")
            turn[0] = 1 - me

    def main():
        scheduler.spawn(lambda: player(1), "other")
        player(0)

    with pytest.raises(RunOver) as over:
        scheduler.run_main(main)
    assert over.value.cause == "duration"


def test_the_run_ends_at_its_duration_and_says_where_the_controller_stood(world):
    scheduler = Scheduler(world, duration_ns=5 * SECOND)
    lines = []

    def main():
        while True:
            lines.append(here() + 1)
            scheduler.sleep(SECOND)

    with pytest.raises(RunOver) as over:
        scheduler.run_main(main)
    assert over.value.cause == "duration"
    assert scheduler.now_ns == 5 * SECOND
    assert (over.value.location.file, over.value.location.line) == (__file__, lines[-1])
    assert over.value.stack[-1][1].endswith("main")


def test_an_except_clause_for_exceptions_does_not_hold_the_end_up(world):
    scheduler = Scheduler(world, duration_ns=2 * SECOND)

    def main():
        while True:
            try:
                scheduler.sleep(SECOND)
            except Exception:  # noqa: BLE001 - as controllers have it
                pytest.fail("the end of the run is no Exception")

    with pytest.raises(RunOver):
        scheduler.run_main(main)


def test_the_end_is_raised_again_at_every_wait(world):
    scheduler = Scheduler(world, duration_ns=SECOND)
    caught = []

    def main():
        for _ in range(5):
            try:
                scheduler.sleep(2 * SECOND)
            except BaseException as error:  # noqa: BLE001
                caught.append(error)
        return "swallowed"

    with pytest.raises(RunOver) as over:
        scheduler.run_main(main)
    assert [type(error) for error in caught] == [RunOver] * 5
    assert over.value.cause == "duration"
    assert scheduler.now_ns == SECOND


def test_a_main_thread_that_swallows_every_end_is_handed_to_the_last_resort(world):
    class ProcessEndedError(Exception):
        """Stands for the end of the process."""

    given_up = []

    def give_up(over):
        given_up.append(over.cause)
        raise ProcessEndedError

    scheduler = Scheduler(world, duration_ns=SECOND)
    scheduler.on_stuck = give_up

    def main():
        while True:
            try:
                scheduler.sleep(SECOND)
            except RunOver:
                continue

    with pytest.raises(RunOver):
        scheduler.run_main(main)
    assert given_up == ["duration"]


def test_a_thread_that_swallows_every_end_does_not_keep_the_others(world):
    scheduler = Scheduler(world, duration_ns=SECOND)

    def stubborn():
        while True:
            try:
                scheduler.sleep(SECOND)
            except RunOver:
                continue

    def main():
        scheduler.spawn(stubborn, "stubborn")
        scheduler.sleep(10 * SECOND)

    with pytest.raises(RunOver) as over:
        scheduler.run_main(main)
    assert over.value.cause == "duration"


def test_main_waits_for_threads_that_are_no_daemons(scheduler):
    log = []

    def worker():
        scheduler.sleep(3 * SECOND)
        log.append(scheduler.now_ns)

    scheduler.run_main(lambda: scheduler.spawn(worker, "worker", daemon=False))
    assert log == [3 * SECOND]


def test_daemon_threads_end_with_main(scheduler):
    log = []

    def worker():
        scheduler.sleep(3 * SECOND)
        log.append("never")

    scheduler.run_main(lambda: scheduler.spawn(worker, "worker"))
    assert log == []
    assert scheduler.now_ns == 0
    assert scheduler.threads == ()


def test_exit_calls_run_last_first_and_in_virtual_time(scheduler):
    log = []

    def main():
        scheduler.exit_calls.at_exit(lambda: log.append(("first", scheduler.now_ns)))
        scheduler.exit_calls.at_exit(
            lambda: (log.append(("last", scheduler.now_ns)), scheduler.sleep(SECOND))
        )

    scheduler.run_main(main)
    assert log == [("last", 0), ("first", SECOND)]


def test_an_endless_wait_for_what_nobody_provides_is_a_deadlock(scheduler):
    lines = []

    def main():
        lines.append(here() + 1)
        scheduler.wait_until(lambda: False, reason="service /add (pkg/Add)", kind="unmet")

    with pytest.raises(RunOver) as over:
        scheduler.run_main(main)
    assert over.value.cause == "deadlock"
    assert over.value.message == (
        "MainThread waits for service /add (pkg/Add), which nothing provides"
    )
    assert over.value.location.line == lines[0]


def test_an_unmet_wait_that_a_periodic_thread_hides_is_a_deadlock_at_the_end(world):
    scheduler = Scheduler(world, duration_ns=3 * SECOND)

    def ticker():
        while True:
            scheduler.sleep(SECOND)

    def main():
        scheduler.spawn(ticker, "ticker")
        scheduler.wait_until(lambda: False, reason="service /add", kind="unmet")

    with pytest.raises(RunOver) as over:
        scheduler.run_main(main)
    assert over.value.cause == "deadlock"
    assert "service /add" in over.value.message


def test_a_thread_that_waits_for_work_makes_a_standstill_a_quiet_end(scheduler):
    def main():
        scheduler.wait_until(lambda: False, reason="callbacks", kind="idle")

    with pytest.raises(RunOver) as over:
        scheduler.run_main(main)
    assert over.value.cause == "quiescent"


def test_background_events_alone_do_not_keep_a_run_going_for_long(scheduler):
    def tick():
        scheduler.call_at(scheduler.now_ns + SECOND // 10, tick, background=True)

    def main():
        tick()
        scheduler.wait_until(lambda: False, reason="callbacks", kind="idle")

    with pytest.raises(RunOver) as over:
        scheduler.run_main(main)
    assert over.value.cause == "quiescent"
    assert scheduler.now_ns == STREAM_PATIENCE_NS


def test_a_background_event_may_bring_what_a_thread_waits_for(scheduler):
    seen = []

    def main():
        scheduler.call_at(SECOND // 50, lambda: seen.append("joint states"), background=True)
        scheduler.wait_until(lambda: bool(seen), reason="a message", kind="unmet")
        return scheduler.now_ns

    assert scheduler.run_main(main) == SECOND // 50


def test_a_motion_that_is_live_keeps_the_run_going(scheduler, world):
    def main():
        world.move(2)
        scheduler.wait_until(lambda: False, reason="callbacks", kind="idle")

    with pytest.raises(RunOver):
        scheduler.run_main(main)
    assert scheduler.now_ns == 2 * SECOND


def test_a_fault_of_the_simulation_leaves_run_main_whatever_the_controller_catches(scheduler):
    class BrokenError(Exception):
        pass

    def fail():
        raise BrokenError("unstable")

    def main():
        scheduler.call_at(SECOND, fail)
        with contextlib.suppress(BaseException):
            scheduler.sleep(2 * SECOND)

    with pytest.raises(BrokenError, match="unstable"):
        scheduler.run_main(main)


def test_the_run_can_be_ended_from_within(scheduler):
    def main():
        scheduler.call_at(SECOND, lambda: scheduler.end("quiescent", "three cycles were seen"))
        scheduler.sleep(10 * SECOND)

    with pytest.raises(RunOver) as over:
        scheduler.run_main(main)
    assert (over.value.cause, over.value.message) == ("quiescent", "three cycles were seen")
    assert scheduler.now_ns == SECOND


def test_a_controller_cannot_wait_outside_its_run(scheduler):
    with pytest.raises(RuntimeError, match="only a thread of the controller"):
        scheduler.sleep(1)


class StackTracer:
    """A tracer whose stack is a list of names, inherited by copies."""

    def __init__(self):
        from contextvars import ContextVar

        self.variable = ContextVar("stack", default=())

    def capture(self):
        return self.variable.get()

    def resume(self, captured):
        from contextlib import contextmanager

        @contextmanager
        def resumed():
            token = self.variable.set(captured)
            try:
                yield
            finally:
                self.variable.reset(token)

        return resumed()

    def root(self, kind):
        return self.resume((f"<{kind}>",))


def test_a_thread_inherits_the_stack_of_its_creator(world):
    tracer = StackTracer()
    scheduler = Scheduler(world, duration_ns=SECOND, tracer=tracer)
    seen = []

    def main():
        with tracer.resume(("main", "pick")):
            scheduler.spawn(lambda: seen.append(tracer.capture()), "heir")
            scheduler.spawn(lambda: seen.append(tracer.capture()), "library", inherit=False)
        scheduler.sleep(0)

    scheduler.run_main(main)
    assert seen == [("main", "pick"), ()]


def test_an_error_of_main_is_reported_though_a_thread_lives_on(scheduler):
    def main():
        scheduler.spawn(
            lambda: scheduler.wait_until(lambda: False, reason="work", kind="idle"),
            "worker",
            daemon=False,
        )
        raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        scheduler.run_main(main)


def test_an_exit_without_an_error_is_no_end_while_a_thread_lives_on(scheduler):
    def main():
        scheduler.spawn(
            lambda: scheduler.wait_until(lambda: False, reason="work", kind="idle"),
            "worker",
            daemon=False,
        )
        raise SystemExit(0)

    with pytest.raises(RunOver, match="the end of thread worker"):
        scheduler.run_main(main)
