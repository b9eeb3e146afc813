"""An answer comes after the first messages of the scenario that the controller listens to."""

from types import SimpleNamespace

import pytest

from tracerisk.pipeline.run.scripted_input import Answers
from tracerisk.ros.controller.needs import NeedLedger
from tracerisk.ros.drafts.answers.known_answers import KnownAnswers
from tracerisk.ros.scenario.topics import ScenarioTopic
from tracerisk.ros.scenario.world import ScenarioWorld

SECOND = 1_000_000_000


class Clock:
    """A scheduler of which only the time passes."""

    def __init__(self):
        self.now_ns = 0
        self.needs = NeedLedger()

    def pass_until(self, time_ns):
        self.now_ns = time_ns

    def wait_until(self, predicate, **_):
        return predicate()

    def touch(self):
        pass

    def miss(self, _):
        pass


def answered(answers, firsts_come_ns, clock):
    recorder = SimpleNamespace(note=lambda *_, **__: None)
    stream = Answers(
        answers, recorder, clock, "cell.py", assume=tuple, progress=lambda: None,
        firsts_come_ns=firsts_come_ns,
    )  # fmt: skip
    return [stream.readline() for _ in answers], clock.now_ns


@pytest.mark.parametrize(
    ("due_s", "after_s"), [([1.0], 1.1), ([], 0.0), ([1.0, 2.0], 2.1)], ids=["one", "none", "later"]
)
def test_an_answer_waits_for_what_is_about_to_come(due_s, after_s):
    clock = Clock()

    def firsts_come_ns():
        return next((round(s * SECOND) for s in due_s if s * SECOND > clock.now_ns), 0)

    lines, now_ns = answered(["y", "n"], firsts_come_ns, clock)
    assert lines == ["y\n", "n\n"]
    assert now_ns == pytest.approx(after_s * SECOND)


@pytest.mark.parametrize(
    ("answers", "after_s"),
    [([], [1, 2, 3]), (["y"], [0, 2, 3]), (["y", "n"], [0, 0, 2]), (["y", "n", "y"], [0, 0, 0])],
)
def test_only_an_assumed_answer_takes_a_second_and_comes_after_the_one_before(answers, after_s):
    """Who scripts answers may mean to give one during a motion."""
    clock, told = Clock(), []
    recorder = SimpleNamespace(note=lambda *_, **__: None, finding=lambda *_, **__: None)
    stream = Answers(
        answers, recorder, clock, "cell.py", assume=lambda: KnownAnswers(("a", "b", "c")),
        progress=lambda: told[-1] if told else None,
    )  # fmt: skip
    for number in range(3):
        stream.prompt = f"{number}?"
        stream.readline()
        told.append(clock.now_ns / SECOND)
    assert told == after_s


@pytest.mark.parametrize(
    ("firsts_s", "wanted_s"), [([1.0, 2.5], 2.5), ([None], 0.0), ([30.0, 1.0], 1.0)]
)
def test_what_comes_much_later_is_not_waited_for(firsts_s, wanted_s):
    topics = [SimpleNamespace(first_ns=None if s is None else s * SECOND) for s in firsts_s]
    world = SimpleNamespace(_topics=topics, schedule=SimpleNamespace(now_ns=0))
    assert ScenarioWorld.firsts_come_ns(world) == wanted_s * SECOND


@pytest.mark.parametrize(
    ("known", "sent", "first_ns", "wanted_ns"),
    [
        ([True], 0, 3 * SECOND, 3 * SECOND),
        ([True], 0, None, 2 * SECOND),
        ([True], 1, 3 * SECOND, None),
        ([False], 0, 3 * SECOND, None),
        ([], 0, 3 * SECOND, None),
    ],
    ids=["due", "not connected yet", "has come", "of another", "nobody listens"],
)
def test_a_first_message_is_due_to_a_controller_that_listens(known, sent, first_ns, wanted_ns):
    listening = [SimpleNamespace(by_controller=each) for each in known]
    topic = SimpleNamespace(
        _publication=SimpleNamespace(
            topic="/goal", graph=SimpleNamespace(subscriptions=lambda _: listening)
        ),
        _schedule=SimpleNamespace(now_ns=SECOND),
        _entry=SimpleNamespace(after=1.0),
        _sent=sent,
        _first_ns=first_ns,
        _is_for_each=True,
    )
    assert ScenarioTopic.first_ns.fget(topic) == wanted_ns
