"""Which calls at given places command motion."""

from __future__ import annotations

from tracerisk.instrument.motion_calls import calls_at

SOURCE = """\
class Node:
    def move(self):
        self.joints.publish(message())
        self.client.send(goal).add_done_callback(self.done)
        self.close(True)
        reach()
        self.arms[0].reach()
"""


def test_calls_are_told_as_they_are_written_and_by_their_last_name_where_that_is_rare():
    assert calls_at(SOURCE.encode(), {(3, 9)}) == {"self.joints.publish"}
    assert calls_at(SOURCE.encode(), {(4, 9)}) == {"self.client.send", "send"}
    assert calls_at(SOURCE.encode(), {(5, 9), (6, 9)}) == {"self.close", "close", "reach"}


def test_what_is_no_plain_name_or_no_call_tells_nothing():
    assert calls_at(SOURCE.encode(), {(7, 9), (1, 1)}) == frozenset()
    assert calls_at(b"def (", {(1, 1)}) == frozenset()
