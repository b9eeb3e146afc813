"""What the clocks of Python tell in virtual time."""

import atexit
import copy
import datetime as dt
import os
import pickle
import select
import signal
import time
from importlib.machinery import ExtensionFileLoader

import pytest

from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.ros.time.patches import virtual_time
from tracerisk.ros.time.scheduler import RunOver, Scheduler

SECOND = 1_000_000_000


def test_the_epoch_is_a_fixed_instant(run):
    assert run(lambda: time.time_ns()) == EPOCH_NS
    assert dt.datetime.fromtimestamp(EPOCH_NS / 1e9, dt.timezone.utc).isoformat() == (
        "2026-01-01T00:00:00+00:00"
    )


@pytest.mark.parametrize(
    "name", ["time", "monotonic", "perf_counter", "process_time", "thread_time"]
)
def test_every_clock_runs_at_the_same_speed(run, name):
    def main():
        start, start_ns = getattr(time, name)(), getattr(time, name + "_ns")()
        time.sleep(2)
        return getattr(time, name)() - start, getattr(time, name + "_ns")() - start_ns

    passed, passed_ns = run(main)
    assert passed == pytest.approx(2.001, abs=1e-6)
    assert passed_ns == 2_001_000_000


def test_a_busy_wait_on_the_clock_ends(run, scheduler):
    def main():
        end = time.time() + 0.5
        while time.time() < end:
            pass

    run(main)
    assert scheduler.now_ns == pytest.approx(0.5 * SECOND, abs=2e6)


def test_sleep_refuses_what_the_real_one_refuses(run):
    def main():
        for value, error in ((-1, ValueError), ("1", TypeError), (float("nan"), ValueError)):
            with pytest.raises(error):
                time.sleep(value)
        with pytest.raises(OverflowError):
            time.sleep(1e300)

    run(main)


def test_dates_follow_the_clock(run):
    def main():
        time.sleep(90)
        return (
            dt.datetime.now(dt.timezone.utc),
            dt.datetime.utcnow(),
            dt.datetime.now(),
            dt.datetime.today(),
            dt.date.today(),
        )

    aware, naive, now, today, date = run(main)
    assert aware.isoformat() == "2026-01-01T00:01:30+00:00"
    assert naive.isoformat() == "2026-01-01T00:01:30.001000"
    assert (today - now).total_seconds() == pytest.approx(0.001)
    assert date == now.date()


def test_a_compiled_module_is_loaded_with_the_classes_whose_layout_it_knows(run, monkeypatch):
    real, seen = dt.datetime, []
    monkeypatch.setattr(
        ExtensionFileLoader, "create_module", lambda *_: seen.append((dt.date, dt.datetime))
    )

    def main():
        ExtensionFileLoader("compiled", "compiled.so").create_module(None)
        return dt.datetime

    assert run(main) is not real
    assert seen == [(dt.date, dt.datetime)]


def test_a_date_of_the_run_is_a_date(run):
    kept = dt.datetime(2020, 1, 1)

    def main():
        now = dt.datetime.now()
        assert isinstance(kept, dt.datetime)
        assert isinstance(now, dt.date)
        assert not isinstance(3, dt.datetime)
        assert now > kept
        assert type(now + dt.timedelta(1)) is type(now)

        class Own(dt.datetime):
            pass

        assert not isinstance(now, Own)
        assert repr(now).startswith("datetime.datetime(")
        return copy.deepcopy(now), pickle.dumps(now)

    now, pickled = run(main)
    assert isinstance(now, dt.datetime)
    assert pickle.loads(pickled) == now


def test_calendar_functions_without_an_argument_follow_the_clock(run):
    def main():
        time.sleep(60)
        return time.gmtime(), time.gmtime(0), time.strftime("%Y-%m-%d", time.gmtime())

    now, epoch, text = run(main)
    assert (now.tm_year, now.tm_min) == (2026, 1)
    assert epoch.tm_year == 1970
    assert text == "2026-01-01"


def test_clock_gettime_follows_the_clock(run):
    assert run(lambda: time.clock_gettime_ns(time.CLOCK_REALTIME)) == EPOCH_NS


def test_select_with_nothing_to_read_passes_virtual_time(run, scheduler):
    reading, writing = os.pipe()

    def main():
        before = select.select([reading], [], [], 0.5)
        os.write(writing, b"x")
        return before, select.select([reading], [], [], 0.5)

    try:
        assert run(main) == (([], [], []), ([reading], [], []))
    finally:
        os.close(reading)
        os.close(writing)
    assert scheduler.now_ns == 0.5 * SECOND


def test_pause_waits_for_ever_and_quietly(run):
    with pytest.raises(RunOver) as over:
        run(lambda: signal.pause())
    assert over.value.cause == "quiescent"


def test_atexit_functions_run_at_the_end_of_the_run(run, scheduler):
    log = []

    def home(name):
        time.sleep(1)
        log.append(name)

    def main():
        atexit.register(home, "first")
        atexit.register(home, name="last")
        forgotten = lambda: log.append("forgotten")  # noqa: E731
        atexit.register(forgotten)
        atexit.unregister(forgotten)

    run(main)
    assert log == ["last", "first"]
    assert scheduler.now_ns == 2 * SECOND


def test_a_log_record_is_stamped_and_moves_no_clock(run, scheduler, caplog):
    import logging

    def main():
        for _ in range(10):
            logging.getLogger("controller").warning("here")

    run(main)
    assert scheduler.now_ns == 0
    assert {record.created for record in caplog.records} == {EPOCH_NS / 1e9}


def test_a_kernel_event_reads_the_clock_without_moving_it(world):
    scheduler = Scheduler(world, duration_ns=SECOND)
    seen = []

    def event():
        seen.extend(time.monotonic() for _ in range(3))

    def main():
        scheduler.call_at(SECOND // 2, event)
        time.sleep(0.6)

    with virtual_time(scheduler):
        scheduler.run_main(main)
    assert seen == [10_000.5] * 3


def test_a_solver_that_times_itself_moves_no_clock(run):
    solver = {"__name__": "qpsolvers.solvers.daqp_"}
    exec("import time\ndef solve():\n    return time.perf_counter()\n", solver)

    def main():
        return [solver["solve"]() for _ in range(5)], [time.perf_counter() for _ in range(3)]

    own, looks = run(main)
    assert len(set(own)) == 1
    assert looks[0] < looks[1] < looks[2]
