"""What `multiprocessing` does in virtual time: as documented, with threads for processes."""

import concurrent.futures
import multiprocessing
import os
import queue
import time

import pytest

SECOND = 1_000_000_000


def squared(number):
    return number * number


class Counter(multiprocessing.Process):
    """A process as a class of its own, which reports through a queue."""

    def __init__(self, results):
        super().__init__(name="counter")
        self.results = results

    def run(self):
        time.sleep(1.5)
        self.results.put((multiprocessing.current_process().name, 3))


def test_a_process_runs_beside_its_parent_and_hands_over_what_it_found(run, scheduler):
    def main():
        results = multiprocessing.Queue()
        process = Counter(results)
        assert process.pid is None
        process.start()
        alive = process.is_alive(), process.exitcode
        found = results.get()
        process.join()
        return alive, found, process.is_alive(), process.exitcode, process.pid != os.getpid()

    assert run(main) == ((True, None), ("counter", 3), False, 0, True)
    assert scheduler.now_ns == pytest.approx(1.5 * SECOND, abs=0.01 * SECOND)


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_a_context_makes_the_same(run, method):
    def main():
        context = multiprocessing.get_context(method)
        results = context.SimpleQueue()
        process = context.Process(target=lambda: results.put(context.current_process().name))
        process.start()
        process.join()
        return results.get()

    assert "Process-" in run(main)


def test_a_process_that_raises_ends_alone(run, scheduler, capsys):
    def main():
        process = multiprocessing.Process(target=lambda: 1 / 0, name="divider")
        process.start()
        process.join()
        return process.exitcode

    assert run(main) == 1
    assert "Process divider:" in capsys.readouterr().err
    assert [name for name, _ in scheduler.failed_threads] == ["divider"]


def test_exit_codes(run):
    def end(how):
        raise SystemExit(how)

    def main():
        codes = []
        for how in (None, 3, "bad"):
            process = multiprocessing.Process(target=end, args=(how,))
            process.start()
            process.join()
            codes.append(process.exitcode)
        return codes

    assert run(main) == [0, 3, 1]


@pytest.mark.parametrize(("way", "code"), [("terminate", -15), ("kill", -9)])
def test_a_process_is_ended(run, scheduler, way, code):
    def main():
        process = multiprocessing.Process(target=time.sleep, args=(100,))
        process.start()
        time.sleep(1)
        getattr(process, way)()
        process.join()
        return process.exitcode

    assert run(main) == code
    assert scheduler.now_ns < 2 * SECOND


def test_a_join_with_a_timeout_returns_while_the_process_runs(run):
    def main():
        process = multiprocessing.Process(target=time.sleep, args=(5,), daemon=True)
        process.start()
        process.join(1)
        return process.is_alive(), [each.name for each in multiprocessing.active_children()]

    alive, children = run(main)
    assert alive
    assert len(children) == 1


def test_a_daemon_is_not_waited_for_and_others_are(run, scheduler):
    def start(daemon):
        multiprocessing.Process(target=time.sleep, args=(2,), daemon=daemon).start()

    run(lambda: start(True))
    assert scheduler.now_ns < SECOND


def test_a_process_that_is_no_daemon_is_waited_for(run, scheduler):
    run(lambda: multiprocessing.Process(target=time.sleep, args=(2,)).start())
    assert scheduler.now_ns == 2 * SECOND
    assert not multiprocessing.active_children(), "this process would wait for it at its end"


def test_what_is_put_is_copied(run):
    def main():
        results, goal = multiprocessing.Queue(), [1.0]
        results.put(goal)
        goal.append(2.0)
        return results.get()

    assert run(main) == [1.0]


def test_a_queue_waits_in_simulated_time(run, scheduler):
    def main():
        with pytest.raises(queue.Empty):
            multiprocessing.Queue().get(timeout=2.0)

    run(main)
    assert scheduler.now_ns == 2 * SECOND


def test_a_pipe_carries_both_ways_and_ends(run):
    def echo(end):
        with end:
            while True:
                try:
                    end.send(end.recv() * 2)
                except EOFError:
                    return

    def main():
        mine, other = multiprocessing.Pipe()
        process = multiprocessing.Process(target=echo, args=(other,))
        process.start()
        mine.send(21)
        found = mine.recv()
        assert not mine.poll(0.5)
        mine.close()
        process.join()
        return found, process.exitcode

    assert run(main) == (42, 0)


def test_values_and_arrays_are_shared(run):
    def add(total, pose):
        with total.get_lock():
            total.value += 1.5
        pose[1] = 7

    def main():
        total, pose = multiprocessing.Value("d", 1.0), multiprocessing.Array("i", 3)
        workers = [multiprocessing.Process(target=add, args=(total, pose)) for _ in range(2)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        return total.value, list(pose), list(multiprocessing.RawArray("d", [1, 2]))

    assert run(main) == (4.0, [0, 7, 0], [1.0, 2.0])


def test_pools_and_managers(run):
    def main():
        with multiprocessing.Pool(2) as pool:
            mapped = pool.map(squared, range(4))
        with concurrent.futures.ProcessPoolExecutor(2) as pool:
            submitted = pool.submit(squared, 5).result()
        with multiprocessing.Manager() as manager:
            shared = manager.dict()
            worker = multiprocessing.Process(target=shared.update, args=({"a": 1},))
            worker.start()
            worker.join()
            return mapped, submitted, dict(shared)

    assert run(main) == ([0, 1, 4, 9], 25, {"a": 1})


def test_an_event_and_a_lock_are_waited_for_in_simulated_time(run, scheduler):
    def main():
        ready, lock = multiprocessing.Event(), multiprocessing.Lock()

        def work():
            time.sleep(1)
            with lock:
                ready.set()

        multiprocessing.Process(target=work).start()
        return ready.wait(5)

    assert run(main)
    assert scheduler.now_ns == SECOND


def test_all_is_put_back(run):
    names = ("Process", "Queue", "Lock", "Pool", "Value", "current_process")
    before = [getattr(multiprocessing, name) for name in names]
    executor = concurrent.futures.ProcessPoolExecutor
    run(lambda: None)
    assert [getattr(multiprocessing, name) for name in names] == before
    assert concurrent.futures.ProcessPoolExecutor is executor
