"""asyncio on its own event loop, in virtual time."""

import asyncio
import threading
import time

import pytest

from tracerisk.ros.time.scheduler import RunOver

SECOND = 1_000_000_000


def test_sleeps_that_are_gathered_take_as_long_as_the_longest(run, scheduler):
    async def step(duration):
        await asyncio.sleep(duration)
        return asyncio.get_running_loop().time() - 10_000

    async def main():
        return await asyncio.gather(step(1), step(3), step(2))

    assert run(lambda: asyncio.run(main())) == [1.0, 3.0, 2.0]
    assert scheduler.now_ns == 3 * SECOND


def test_wait_for_times_out(run, scheduler):
    async def main():
        with pytest.raises(asyncio.TimeoutError):
            await asyncio.wait_for(asyncio.Event().wait(), 2)

    run(lambda: asyncio.run(main()))
    assert scheduler.now_ns == 2 * SECOND


def test_call_later_calls_in_order_of_time(run):
    log = []

    async def main():
        loop = asyncio.get_running_loop()
        loop.call_later(0.2, log.append, "b")
        loop.call_later(0.1, log.append, "a")
        await asyncio.sleep(0.3)

    run(lambda: asyncio.run(main()))
    assert log == ["a", "b"]


def test_an_executor_works_beside_the_loop(run, scheduler):
    ticks = []

    async def tick():
        for _ in range(3):
            await asyncio.sleep(0.4)
            ticks.append(asyncio.get_running_loop().time() - 10_000)

    async def main():
        loop = asyncio.get_running_loop()
        ticking = asyncio.create_task(tick())
        await loop.run_in_executor(None, time.sleep, 1)
        ticks.append("executor")
        await ticking

    run(lambda: asyncio.run(main()))
    assert ticks == [pytest.approx(0.4), pytest.approx(0.8), "executor", pytest.approx(1.2)]
    assert scheduler.now_ns == pytest.approx(1.2 * SECOND, abs=1e4)


def test_another_thread_wakes_the_loop(run):
    async def main():
        loop = asyncio.get_running_loop()
        future = loop.create_future()

        def work():
            time.sleep(1)
            loop.call_soon_threadsafe(future.set_result, "done")

        threading.Thread(target=work).start()
        return await future

    assert run(lambda: asyncio.run(main())) == "done"


def test_a_loop_in_a_thread_takes_coroutines_from_another(run):
    async def job():
        await asyncio.sleep(1)
        return "done"

    def main():
        loop = asyncio.new_event_loop()
        thread = threading.Thread(target=loop.run_forever, daemon=True)
        thread.start()
        result = asyncio.run_coroutine_threadsafe(job(), loop).result(timeout=5)
        loop.call_soon_threadsafe(loop.stop)
        thread.join()
        loop.close()
        return result

    assert run(main) == "done"


def test_a_coroutine_that_yields_in_a_loop_lets_time_pass(run, scheduler):
    async def main():
        flag = []
        asyncio.get_running_loop().call_later(0.1, flag.append, True)
        while not flag:
            await asyncio.sleep(0)

    run(lambda: asyncio.run(main()))
    assert scheduler.now_ns == pytest.approx(0.1 * SECOND, abs=2e6)


def test_a_busy_wait_on_the_time_of_the_loop_ends(run):
    async def main():
        loop = asyncio.get_running_loop()
        end = loop.time() + 0.05
        while loop.time() < end:
            pass

    run(lambda: asyncio.run(main()))


def test_an_await_that_nothing_ends_is_a_deadlock(run):
    async def main():
        await asyncio.get_running_loop().create_future()

    with pytest.raises(RunOver) as over:
        run(lambda: asyncio.run(main()))
    assert over.value.cause == "deadlock"
    assert over.value.location.file == __file__
