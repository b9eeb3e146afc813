"""Commands with their stacks, as the libraries' calls report them."""

from __future__ import annotations

import functools
import itertools
import os
import sys
import threading
import time
from typing import Any, Callable, Sequence

from tracerisk_probe.stacks import Frame, stack
from tracerisk_probe.writing import FORMAT, Output

_output: Output | None = None
_next_id = itertools.count(1).__next__
_within = threading.local()


def record_to(output: Output, controller: str) -> None:
    """Record from now on."""
    global _output
    output.put(
        {
            "t": now_s(),
            "kind": "begin",
            "format": FORMAT,
            "controller": controller,
            "pid": os.getpid(),
        }
    )
    _output = output


def output() -> Output | None:
    """Return where is recorded to; None where nothing is."""
    return _output


def now_s() -> float:
    """Return the time of ROS 1 where its node is up, else since 1970 [s]."""
    rospy = sys.modules.get("rospy")
    if rospy is not None:
        try:
            if rospy.core.is_initialized():
                return float(rospy.get_time())
        except Exception:  # noqa: BLE001 -- half imported, or a stand-in of the controller's own
            pass
    return time.time()


class Within:
    """Context manager: what is called within a command is part of it, and no other one."""

    def __enter__(self) -> None:
        _within.depth = vars(_within).get("depth", 0) + 1

    def __exit__(self, *error: Any) -> None:
        _within.depth -= 1


def command(kind: str, name: str, type_: str, joints: Sequence[str] = ()) -> int:
    """Record a command; return its number, 0 where it is none of the controller's own."""
    if _output is None or vars(_within).get("depth"):
        return 0
    frames: Sequence[Frame] = stack()
    if not frames:
        return 0
    number = _next_id()
    fields = {
        "t": now_s(),
        "kind": kind,
        "name": name,
        "type": type_,
        "id": number,
        "pid": os.getpid(),
    }
    if joints:
        fields["joints"] = list(joints)
    _output.put(fields, frames)
    return number


def ended(number: int, outcome: str) -> None:
    """Record that a command ended: `succeeded`, `aborted` or `preempted`."""
    if _output is not None and number:
        _output.put(
            {"t": now_s(), "kind": "end", "id": number, "pid": os.getpid(), "outcome": outcome}
        )


def watch(function: Callable[..., Any], name: str = "", type: str = "") -> Callable[..., Any]:  # noqa: A002
    """Return a function whose calls are commands, which end when it returns.

    `name` and `type` are what the commands are called; default: the function's own.
    """
    own = name or getattr(function, "__name__", "call")
    kind = type or getattr(function, "__qualname__", own)

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        number = command("method", own, kind)
        try:
            with Within():
                result = function(*args, **kwargs)
        except BaseException:
            ended(number, "aborted")
            raise
        ended(number, "succeeded")
        return result

    return call
