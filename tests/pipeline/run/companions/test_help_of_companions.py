"""Whether nodes beside a controller were of help, by what their runs lacked still."""

from types import SimpleNamespace

import pytest

from tracerisk.config import Settings
from tracerisk.pipeline.run import attempts
from tracerisk.ros.controller.needs import Need

SERVICE = Need("service", "/turn", "std_srvs/Trigger")
CALL = Need("call", "/pick", "std_srvs/Trigger")
NODE = SimpleNamespace(told="scripts/turner.py")


def ran(cause, *needs, moved_by=()):
    functions = tuple(SimpleNamespace(ref=SimpleNamespace(file=file)) for file in moved_by)
    end = SimpleNamespace(cause=cause, location=None, is_good=cause == "ended")
    return SimpleNamespace(trace=SimpleNamespace(end=end, functions=functions), needs=needs)


@pytest.mark.parametrize(
    ("beside", "has_helped", "counts"),
    [
        (ran("exited", SERVICE), False, False),
        (ran("quiescent", CALL), True, False),
        (ran("quiescent"), True, False),
        (ran("ended", moved_by=("scripts/front.py",)), False, True),
        (ran("ended", moved_by=("scripts/turner.py",)), False, False),
        (ran("wall_limit"), False, True),
    ],
    ids=["of no use", "a call lacks", "nothing lacks", "all is well", "moves unasked", "cut short"],
)
def test_a_node_has_helped_where_the_run_beside_it_lacks_something_else(
    monkeypatch, beside, has_helped, counts
):
    found = iter([(NODE,)])
    monkeypatch.setattr(attempts, "find_companions", lambda *_: next(found, ()))
    accompanied = attempts._with_companions(
        None, Settings(), ran("exited", SERVICE), lambda _: beside, lambda: True
    )
    assert accompanied.has_helped is has_helped
    assert (accompanied.trace is beside.trace) is counts
