"""What is a thread's own stays its own where the threads of a controller are greenlets."""

import asyncio
import contextlib
import contextvars
import signal
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from tracerisk.ros.time.greenlet_baton import GreenletBaton

BEFORE = threading.local()
VARIABLE = contextvars.ContextVar("variable", default="unset")


@pytest.fixture
def baton() -> GreenletBaton:
    return GreenletBaton()


def in_turns(*works: Any) -> list[Any]:
    """Run each in a thread of its own, and return what they returned."""
    found: list[Any] = [None] * len(works)

    def run(at: int) -> None:
        found[at] = works[at]()

    threads = [threading.Thread(target=run, args=(at,)) for at in range(len(works))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return found


def test_all_of_them_are_one_real_thread(run):
    import _thread

    real = _thread.get_ident

    def main():
        reported = in_turns(real, real, threading.get_ident, threading.get_ident)
        return real(), threading.get_ident(), reported

    main_real, main_ident, (one, other, first, second) = run(main)
    assert one == other == main_real == main_ident
    assert len({first, second, main_ident}) == 3


@pytest.mark.parametrize(
    "before",
    [
        False,
        pytest.param(
            True,
            marks=pytest.mark.skipif(
                sys.version_info >= (3, 13), reason="out of reach from Python 3.13 on"
            ),
        ),
    ],
)
def test_a_local_is_a_threads_own_whether_made_before_or_during_the_run(run, before):
    def main():
        local = BEFORE if before else threading.local()
        local.value = "main"

        def work(name: str) -> Any:
            had = hasattr(local, "value")
            local.value = name
            time.sleep(1.0)
            return had, local.value

        reported = in_turns(lambda: work("a"), lambda: work("b"))
        return reported, local.value

    assert run(main) == ([(False, "a"), (False, "b")], "main")


def test_a_context_is_a_threads_own(run):
    def main():
        VARIABLE.set("main")

        def work(name: str) -> Any:
            before = VARIABLE.get()
            VARIABLE.set(name)
            time.sleep(1.0)
            return before, VARIABLE.get()

        return in_turns(lambda: work("a"), lambda: work("b")), VARIABLE.get()

    assert run(main) == ([("unset", "a"), ("unset", "b")], "main")


def test_an_exception_that_is_handled_is_a_threads_own(run):
    def main():
        def work(name: str) -> Any:
            try:
                raise ValueError(name)
            except ValueError:
                time.sleep(1.0)
                return str(sys.exc_info()[1])

        return in_turns(lambda: work("a"), lambda: work("b")), sys.exc_info()[1]

    assert run(main) == (["a", "b"], None)


def test_two_event_loops_run_at_once(run):
    def main():
        async def tick(name: str) -> Any:
            loop = asyncio.get_running_loop()
            for _ in range(3):
                await asyncio.sleep(0.5)
                # Blocks the loop within its task, while the other one runs.
                time.sleep(0.25)
                assert asyncio.get_running_loop() is loop
                assert asyncio.current_task() is not None
            return name, round(loop.time(), 2)

        return in_turns(lambda: asyncio.run(tick("a")), lambda: asyncio.run(tick("b")))

    (one, first_s), (other, second_s) = run(main)
    assert (one, other) == ("a", "b")
    assert first_s == second_s


def test_an_event_loop_of_a_thread_is_no_other_threads(run):
    def main():
        def work() -> Any:
            loop = asyncio.new_event_loop()
            asyncio.set_event_loop(loop)
            time.sleep(1.0)
            is_own = asyncio.get_event_loop() is loop
            loop.close()
            return is_own

        return in_turns(work, work)

    assert run(main) == [True, True]


def test_an_asynchronous_generator_ends_in_its_loop(run):
    ended: list[str] = []

    def main():
        async def numbers(name: str) -> Any:
            try:
                for number in range(3):
                    yield number
                    await asyncio.sleep(0.1)
            finally:
                ended.append(name)

        async def first_of(name: str) -> int:
            async for number in numbers(name):
                time.sleep(0.5)
                return number
            return -1

        return in_turns(lambda: asyncio.run(first_of("a")), lambda: asyncio.run(first_of("b")))

    assert run(main) == [0, 0]
    assert sorted(ended) == ["a", "b"]


def test_a_trace_function_is_a_threads_own(run):
    seen: list[str] = []

    def main():
        def trace(frame: Any, event: str, argument: Any) -> None:
            seen.append(frame.f_code.co_name)

        def marked_traced() -> None: ...

        def marked_untraced() -> None: ...

        def traced() -> None:
            sys.settrace(trace)
            time.sleep(1.0)
            marked_traced()

        def untraced() -> None:
            time.sleep(0.5)
            marked_untraced()

        in_turns(traced, untraced)
        return sys.gettrace()

    before = sys.gettrace()
    assert run(main) is before
    assert "marked_traced" in seen
    assert "marked_untraced" not in seen


def test_signals_are_set_in_the_main_thread_alone(run):
    def main():
        def work() -> str:
            with pytest.raises(ValueError, match="main thread") as reported:
                signal.signal(signal.SIGUSR2, signal.SIG_DFL)
            return str(reported.value)

        before = signal.signal(signal.SIGUSR2, signal.SIG_IGN)
        signal.signal(signal.SIGUSR2, before)
        return in_turns(work)

    assert run(main) == ["signal only works in main thread of the main interpreter"]


def test_an_executor_returns_and_raises(run):
    def fail() -> None:
        raise LookupError("no")

    def main():
        with ThreadPoolExecutor(2) as pool:
            found = list(pool.map(lambda n: (time.sleep(0.5), n * n)[1], range(5)))
            failed = pool.submit(fail)
        return found, type(failed.exception()), time.monotonic() > 0

    assert run(main) == ([0, 1, 4, 9, 16], LookupError, True)


def test_who_swallows_the_end_of_the_run_gets_no_turn_any_more(run):
    def main():
        def stubborn() -> None:
            while True:
                with contextlib.suppress(BaseException):
                    time.sleep(1.0)

        threading.Thread(target=stubborn, daemon=True).start()
        time.sleep(3.0)
        return "ended"

    assert run(main) == "ended"


def test_a_thread_of_others_goes_its_own_way(run):
    from _thread import allocate_lock, get_ident, start_new_thread

    def main():
        done, reported = allocate_lock_real(), []
        done.acquire()

        def others() -> None:
            reported.append((threading.get_ident() == get_ident(), threading.get_ident()))
            done.release()

        start_new_thread(others, ())
        with done:
            return reported[0][0], reported[0][1] != threading.get_ident()

    allocate_lock_real = allocate_lock
    assert run(main) == (True, True)
