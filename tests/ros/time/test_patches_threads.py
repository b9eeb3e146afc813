"""What `threading`, `queue` and `concurrent.futures` do in virtual time: as documented."""

import _thread
import os
import queue
import random
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor, as_completed, wait

import pytest

from tracerisk.ros.time.patches import virtual_time
from tracerisk.ros.time.scheduler import RunOver, Scheduler

SECOND = 1_000_000_000


def test_two_threads_that_sleep_interleave_by_time(run):
    log = []

    def worker(name, period):
        for _ in range(3):
            time.sleep(period)
            log.append((name, round(time.monotonic() - start, 3)))

    start = 10_000.0

    def main():
        threads = [threading.Thread(target=worker, args=a) for a in (("a", 0.2), ("b", 0.3))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    run(main)
    assert log == [("a", 0.2), ("b", 0.3), ("a", 0.4), ("b", 0.6), ("a", 0.6), ("b", 0.9)]


def test_a_thread_that_is_no_daemon_is_waited_for(run, scheduler):
    run(lambda: threading.Thread(target=lambda: time.sleep(2)).start())
    assert scheduler.now_ns == 2 * SECOND


def test_a_daemon_is_not_waited_for(run, scheduler):
    run(lambda: threading.Thread(target=time.sleep, args=(2,), daemon=True).start())
    assert scheduler.now_ns == 0


def test_join_with_a_timeout_returns_while_the_thread_lives(run):
    def main():
        thread = threading.Thread(target=time.sleep, args=(5,))
        thread.start()
        thread.join(1)
        was_alive = thread.is_alive()
        thread.join()
        return was_alive, thread.is_alive()

    assert run(main) == (True, False)


def test_polling_is_alive_lets_the_thread_finish(run, scheduler):
    def main():
        thread = threading.Thread(target=time.sleep, args=(0.05,))
        thread.start()
        while thread.is_alive():
            pass

    run(main)
    assert scheduler.now_ns == pytest.approx(0.05 * SECOND, abs=2e6)


def test_a_timer_fires_after_its_interval_and_not_when_cancelled(run):
    fired = []

    def main():
        threading.Timer(2, lambda: fired.append(time.monotonic())).start()
        cancelled = threading.Timer(1, lambda: fired.append("cancelled"))
        cancelled.start()
        cancelled.cancel()

    run(main)
    assert fired == [10_002.0]


def test_a_lock_excludes_and_is_handed_on_in_order(run):
    log = []

    def worker(name, lock):
        with lock:
            log.append(("in", name))
            time.sleep(1)
            log.append(("out", name))

    def main():
        lock = threading.Lock()
        for name in "abc":
            threading.Thread(target=worker, args=(name, lock)).start()

    run(main)
    assert log == [(what, name) for name in "abc" for what in ("in", "out")]


def test_a_reentrant_lock_can_be_taken_again_by_its_owner_alone(run):
    def main():
        lock = threading.RLock()
        taken = []
        with lock, lock:
            other = threading.Thread(target=lambda: taken.append(lock.acquire(timeout=1)))
            other.start()
            other.join()
        return taken

    assert run(main) == [False]


def test_acquire_with_a_timeout_gives_up_in_time(run, scheduler):
    def main():
        lock = threading.Lock()
        lock.acquire()
        return lock.acquire(timeout=1.5)

    assert run(main) is False
    assert scheduler.now_ns == 1.5 * SECOND


def test_bad_arguments_of_acquire_raise_as_the_real_ones(run):
    def main():
        lock = threading.Lock()
        for arguments, error in (
            ((False, 1), ValueError),
            ((True, -2), ValueError),
            ((True, 1e20), OverflowError),
        ):
            with pytest.raises(error):
                lock.acquire(*arguments)
        with pytest.raises(RuntimeError):
            lock.release()

    run(main)


def test_a_condition_wakes_the_first_waiter_and_times_out(run):
    log = []

    def waiter(condition, name):
        with condition:
            log.append((name, condition.wait(timeout=3), time.monotonic() - 10_000))

    def main():
        condition = threading.Condition()
        for name in "ab":
            threading.Thread(target=waiter, args=(condition, name)).start()
        time.sleep(1)
        with condition:
            condition.notify()

    run(main)
    assert log == [("a", True, 1.0), ("b", False, 3.0)]


def test_wait_for_counts_its_timeout_in_virtual_time(run, scheduler):
    def main():
        condition = threading.Condition()
        with condition:
            return condition.wait_for(lambda: False, timeout=2.5)

    assert run(main) is False
    assert scheduler.now_ns == 2.5 * SECOND


def test_an_event_that_is_polled_is_seen(run, scheduler):
    def main():
        event = threading.Event()
        threading.Timer(0.1, event.set).start()
        while not event.is_set():
            pass

    run(main)
    assert scheduler.now_ns == pytest.approx(0.1 * SECOND, abs=2e6)


def test_semaphore_and_barrier_work(run):
    log = []

    def worker(semaphore, barrier, name):
        with semaphore:
            time.sleep(1)
        barrier.wait()
        log.append((name, time.monotonic() - 10_000))

    def main():
        semaphore, barrier = threading.Semaphore(2), threading.Barrier(3)
        for name in "abc":
            threading.Thread(target=worker, args=(semaphore, barrier, name)).start()

    run(main)
    assert sorted(log) == [("a", 2.0), ("b", 2.0), ("c", 2.0)]


def test_a_queue_hands_over_and_times_out(run):
    log = []

    def consumer(work):
        while True:
            try:
                item = work.get(timeout=2)
            except queue.Empty:
                log.append(("empty", time.monotonic() - 10_000))
                return
            log.append((item, time.monotonic() - 10_000))
            work.task_done()

    def main():
        work = queue.Queue()
        threading.Thread(target=consumer, args=(work,)).start()
        for item in range(2):
            time.sleep(1)
            work.put(item)
        work.join()

    run(main)
    assert log == [(0, 1.0), (1, 2.0), ("empty", 4.0)]


@pytest.mark.parametrize("kind", ["Queue", "SimpleQueue"])
def test_polling_an_empty_queue_lets_the_producer_work(run, kind):
    def main():
        work = getattr(queue, kind)()
        threading.Timer(0.05, work.put, args=("item",)).start()
        while True:
            try:
                return work.get_nowait()
            except queue.Empty:
                continue

    assert run(main) == "item"


def test_low_level_threads_are_under_the_baton(run):
    log = []

    def main():
        lock = _thread.allocate_lock()
        lock.acquire()

        def worker():
            time.sleep(1)
            log.append(time.monotonic() - 10_000)
            lock.release()

        _thread.start_new_thread(worker, ())
        lock.acquire()

    run(main)
    assert log == [1.0]


def test_a_pool_runs_as_many_at_once_as_it_has_workers(run, scheduler):
    def main():
        with ThreadPoolExecutor(2) as pool:
            futures = [pool.submit(time.sleep, 1) for _ in range(4)]
            done, _ = wait(futures[:2])
            assert len(done) == 2
            return [future.result() for future in as_completed(futures)]

    assert run(main) == [None] * 4
    assert scheduler.now_ns == 2 * SECOND


def test_a_pool_that_is_left_open_finishes_its_work_at_exit(run, scheduler):
    log = []

    def main():
        pool = ThreadPoolExecutor(1)
        for item in range(3):
            pool.submit(lambda i=item: (time.sleep(1), log.append(i)))

    run(main)
    assert log == [0, 1, 2]
    assert scheduler.now_ns == 3 * SECOND


def test_two_threads_may_submit_while_a_worker_starts(run):
    def main():
        pool = ThreadPoolExecutor(4)
        others = [threading.Thread(target=pool.submit, args=(time.sleep, 1)) for _ in range(3)]
        for other in others:
            other.start()
        return pool.submit(lambda: "done").result()

    assert run(main) == "done"


def test_polling_a_future_ends(run):
    def main():
        with ThreadPoolExecutor(1) as pool:
            future = pool.submit(time.sleep, 0.05)
            while not future.done():
                pass
        return True

    assert run(main)


def test_a_submitted_call_inherits_the_stack_of_its_submitter(world):
    from contextlib import contextmanager
    from contextvars import ContextVar

    class Tracer:
        def __init__(self):
            self.stack = ContextVar("stack", default=())

        def capture(self):
            return self.stack.get()

        @contextmanager
        def resume(self, captured):
            token = self.stack.set(captured)
            try:
                yield
            finally:
                self.stack.reset(token)

        def root(self, kind):
            return self.resume((kind,))

    tracer = Tracer()
    scheduler = Scheduler(world, duration_ns=SECOND, tracer=tracer)
    seen = []

    def main():
        with ThreadPoolExecutor(1) as pool:
            with tracer.resume(("init",)):
                pool.submit(int).result()
            with tracer.resume(("place",)):
                future = pool.submit(lambda: seen.append(tracer.capture()))
                future.add_done_callback(lambda _: seen.append(tracer.capture()))

    with virtual_time(scheduler):
        scheduler.run_main(main)
    assert seen == [("place",), ("done_callback",)]


def test_two_threads_that_take_two_locks_crosswise_are_a_deadlock_with_its_place(run):
    def other(first, second):
        with first:
            time.sleep(1)
            with second:
                pass

    def main():
        first, second = threading.Lock(), threading.Lock()
        threading.Thread(target=other, args=(first, second)).start()
        with second:
            time.sleep(1)
            with first:
                pass

    with pytest.raises(RunOver) as over:
        run(main)
    assert over.value.cause == "deadlock"
    assert "none of them can go on" in over.value.message
    assert over.value.location.file == __file__


def test_a_lock_taken_twice_by_one_thread_is_a_deadlock(run):
    def main():
        lock = threading.Lock()
        lock.acquire()
        lock.acquire()

    with pytest.raises(RunOver) as over:
        run(main)
    assert over.value.cause == "deadlock"
    assert over.value.location.line == main.__code__.co_firstlineno + 3


def test_a_join_of_a_thread_that_waits_for_the_joiners_lock_is_a_deadlock(run):
    def main():
        lock = threading.Lock()

        def worker():
            with lock:
                pass

        thread = threading.Thread(target=worker)
        with lock:
            thread.start()
            thread.join()

    with pytest.raises(RunOver) as over:
        run(main)
    assert over.value.cause == "deadlock"
    assert "waits for a lock" in over.value.message
    assert "waits for the end of thread" in over.value.message


def test_an_endless_get_names_the_queue_and_the_line(run):
    def main():
        queue.Queue().get()

    with pytest.raises(RunOver) as over:
        run(main)
    assert over.value.cause == "deadlock"
    assert "Queue.get" in over.value.message
    assert over.value.location.line == main.__code__.co_firstlineno + 1


def test_a_thread_that_dies_is_reported_and_the_others_go_on(run, scheduler, capsys, monkeypatch):
    monkeypatch.setattr(threading, "excepthook", threading.__excepthook__)

    def main():
        thread = threading.Thread(target=lambda: {}["missing"], name="worker")
        thread.start()
        thread.join()
        return "went on"

    assert run(main) == "went on"
    assert [(name, type(error)) for name, error in scheduler.failed_threads] == [
        ("worker", KeyError)
    ]
    assert "Exception in thread worker" in capsys.readouterr().err


def test_the_end_of_the_run_is_no_exception_of_a_thread(world, capsys):
    scheduler = Scheduler(world, duration_ns=SECOND)
    cleaned = []

    def worker():
        try:
            time.sleep(100)
        finally:
            cleaned.append(True)

    def main():
        threading.Thread(target=worker).start()
        time.sleep(100)

    with virtual_time(scheduler), pytest.raises(RunOver):
        scheduler.run_main(main)
    assert cleaned == [True]
    assert scheduler.failed_threads == []
    assert capsys.readouterr().err == ""


def interleave(scheduler, seed):
    chance = random.Random(seed)
    log = []

    def worker(name):
        for step in range(chance.randrange(1, 6)):
            log.append((name, step, time.monotonic_ns()))
            chance.choice(
                (time.sleep, lambda s: lock.acquire() and (time.sleep(s), lock.release()))
            )(chance.randrange(3) / 100)

    def main():
        for index in range(chance.randrange(3, 8)):
            threading.Thread(target=worker, args=(index,)).start()
            if chance.random() < 0.5:
                time.sleep(chance.random() / 100)

    with virtual_time(scheduler):
        lock = None

        def whole():
            nonlocal lock
            lock = threading.Lock()
            main()

        scheduler.run_main(whole)
    return log


@pytest.mark.parametrize("seed", range(20))
def test_threads_that_start_at_random_interleave_the_same_twice(seed, world):
    first = interleave(Scheduler(world, duration_ns=10 * SECOND), seed)
    again = interleave(Scheduler(type(world)(), duration_ns=10 * SECOND), seed)
    assert len(first) > 2
    assert first == again


def test_two_threads_that_import_a_slow_module_wait_for_it_once(run, scheduler, tmp_path):
    (tmp_path / "slow_to_import.py").write_text("import time\ntime.sleep(2)\nREADY = 1\n")
    seen = []

    def load():
        import slow_to_import

        seen.append((slow_to_import.READY, scheduler.now_ns))

    def main():
        sys.path.insert(0, str(tmp_path))
        try:
            threads = [threading.Thread(target=load) for _ in range(2)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        finally:
            sys.path.remove(str(tmp_path))
            del sys.modules["slow_to_import"]

    run(main)
    assert seen == [(1, 2 * SECOND)] * 2


def test_a_controller_cannot_fork_the_simulation(run):
    with pytest.raises(RuntimeError, match="runs in one process"):
        run(lambda: os.fork())


def test_everything_is_put_back(run):
    watched = (
        (threading, "Lock RLock _allocate_lock _time _make_invoke_excepthook"),
        (time, "time sleep monotonic perf_counter localtime"),
        (queue, "SimpleQueue time"),
        (_thread, "allocate_lock start_new_thread"),
    )
    before = [(o, n, getattr(o, n)) for o, names in watched for n in names.split()]
    run(lambda: None)
    assert [(o, n) for o, n, value in before if getattr(o, n) is not value] == []


def test_locks_and_queues_of_a_run_work_after_it(run):
    kept = run(lambda: (threading.Lock(), threading.RLock(), queue.Queue(), queue.SimpleQueue()))
    lock, reentrant, work, simple = kept
    with lock, reentrant, reentrant:
        assert lock.locked()
    for each in (work, simple):
        threading.Thread(target=each.put, args=(1,)).start()
        assert each.get(timeout=10) == 1


def test_threads_of_others_keep_the_real_clock_and_real_locks(run):
    real = time.time()
    release = _thread.allocate_lock()
    release.acquire()
    seen = []
    reader, writer = os.pipe()

    def foreign():
        with release:
            seen.append((time.time(), type(threading.Lock()) is type(release)))
        os.write(writer, b".")

    def main():
        time.sleep(100)
        release.release()
        # Waits for as long as the machine needs, in no time of the simulation.
        os.read(reader, 1)

    thread = threading.Thread(target=foreign)
    thread.start()
    run(main)
    thread.join()
    os.close(reader)
    os.close(writer)
    assert abs(seen[0][0] - real) < 60
    assert seen[0][1]
