"""What it means when every thread waits and nothing is due: a quiet end, or a hang."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from tracerisk.ros.controller.frames import controller_stack, library_call
from tracerisk.ros.controller.programs import Awaited
from tracerisk.ros.controller.thread import ControllerThread, RunOver
from tracerisk.trace import EndCause

LONG_NS = 60_000_000_000
"""For how long a thread must have waited before that is a hang [ns]."""


def end_of_standstill(threads: Iterable[ControllerThread], *, listens: bool) -> RunOver:
    """Judge a standstill: no thread can go on, no event is due and nothing moves.

    It is a deadlock where a thread waits for a thing that nothing provides, where threads hold
    each other's locks, or where nothing listens to the world outside (`listens`: the controller
    subscribes to a topic or serves something).
    Else it is a quiet end, as of a node that spins. What a companion waits for is none of it.
    """
    waiting = sorted(
        (thread for thread in threads if thread.wait is not None and thread.process is None),
        key=lambda thread: _since(thread),
    )
    for thread in waiting:
        if _kind(thread) == "unmet":
            text = f"{_in_words(thread)}, which nothing provides{_why(thread)}"
            return _over("deadlock", thread, text)
    for thread in waiting:
        if circle := _circle(thread):
            text = " and ".join(_in_words(member) for member in circle)
            return _over("deadlock", thread, f"{text}: none of them can go on")
    main = next((thread for thread in waiting if thread.is_main), None)
    if main is None:
        return RunOver("quiescent", "nothing can happen any more")
    if listens or any(_kind(thread) == "idle" for thread in waiting):
        return _over("quiescent", main, f"nothing can happen any more: {_in_words(main)}")
    last = _chain(main)[-1]
    return _over("deadlock", last, f"{_in_words(last)}, which nothing can end")


def wait_without_limit(awaited: Mapping[ControllerThread, Awaited]) -> RunOver:
    """Report which thread waits for a program without a limit."""
    order = sorted(
        awaited, key=lambda thread: (awaited[thread].limit_s is not None, _since(thread))
    )
    return _over("wall_limit", order[0], f"{_in_words(order[0])}, which does not answer")


def end_of_duration(main: ControllerThread | None, duration_ns: int) -> RunOver:
    """Report that the simulated time is over, and where the main thread stands.

    A main thread that has long waited, without a limit, for what nothing provided is a deadlock:
    other threads only hid the standstill. One that waits for the result of its last goal is none.
    """
    seconds = f"{duration_ns / 1e9:g} s"
    if main is None or main.wait is None:
        return RunOver("duration", f"the {seconds} of simulated time are over")
    is_endless = _kind(main) == "unmet" and main.wait.deadline_ns is None
    if is_endless and duration_ns - main.wait.since_ns >= min(LONG_NS, 0.9 * duration_ns):
        text = f"{_in_words(main)}, which nothing provided within {seconds}{_why(main)}"
        return _over("deadlock", main, text)
    return _over("duration", main, f"the {seconds} of simulated time are over: {_in_words(main)}")


def _since(thread: ControllerThread) -> int:
    return thread.wait.since if thread.wait is not None else -1


def _kind(thread: ControllerThread) -> str | None:
    return thread.wait.kind if thread.wait is not None else None


def _in_words(thread: ControllerThread) -> str:
    if thread.wait is None:
        return f"{thread.name} runs"
    called = library_call(thread.wait.frame)
    return f"{thread.name} waits for {thread.wait.reason}" + (f" ({called})" if called else "")


def _why(thread: ControllerThread) -> str:
    why = thread.wait.meaning().why if thread.wait is not None else ""
    return f": {why}" if why else ""


def _over(cause: EndCause, thread: ControllerThread, message: str) -> RunOver:
    stack = controller_stack(thread.wait.frame) if thread.wait is not None else ()
    return RunOver(cause, message, stack[-1][0] if stack else None, stack)


def _waits_for(thread: ControllerThread) -> ControllerThread | None:
    if thread.wait is None or thread.wait.on is None:
        return None
    on = thread.wait.on
    return on if isinstance(on, ControllerThread) else on.holder


def _chain(start: ControllerThread) -> Sequence[ControllerThread]:
    """Return the threads that wait for each other, beginning with `start`."""
    chain = [start]
    while (following := _waits_for(chain[-1])) is not None and following.wait is not None:
        if following in chain:
            break
        chain.append(following)
    return chain


def _circle(start: ControllerThread) -> Sequence[ControllerThread]:
    """Return the threads that wait for each other's locks or ends in a ring through `start`."""
    chain = _chain(start)
    return chain if _waits_for(chain[-1]) is start else ()
