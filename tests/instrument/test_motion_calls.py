"""Which calls at given places command motion."""

from __future__ import annotations

from tracerisk.instrument.motion_calls import MissedCall, calls_at, missed_calls

SOURCE = """\
class Node:
    def move(self):
        self.joints.publish(message())
        self.client.send(goal).add_done_callback(self.done)
        self.close(True)
        reach()
        self.arms[0].reach()
"""


def test_calls_are_reported_as_they_are_written_and_by_their_last_name_where_that_is_rare():
    assert calls_at(SOURCE.encode(), {(3, 9)}) == {"self.joints.publish"}
    assert calls_at(SOURCE.encode(), {(4, 9)}) == {"self.client.send", "send"}
    assert calls_at(SOURCE.encode(), {(5, 9), (6, 9)}) == {"self.close", "close", "reach"}


def test_what_is_no_plain_name_or_no_call_says_nothing():
    assert calls_at(SOURCE.encode(), {(7, 9), (1, 1)}) == frozenset()
    assert calls_at(b"def (", {(1, 1)}) == frozenset()


CELL = """\
class Cell:
    def run(self):
        self.arm.go(home)
        if self.ready():
            self.arm.go(tray)
            self.grip(0.0)
        return self.grip(0.08)

    def grip(self, width):
        publisher.publish(width)

    def tell(self):
        publisher.publish(self.state)

    async def serve(self):
        self.arm.go(home)
"""
# The calls of run (3 and 7) and the one inside grip led to commands.
MADE = {(3, 9), (7, 16), (10, 9)}


def test_a_call_that_led_to_no_command_is_missed_where_the_same_one_did_elsewhere():
    assert missed_calls(CELL.encode(), MADE, {"grip"}) == (
        MissedCall(5, "self.arm.go"),
        MissedCall(6, "self.grip"),
    )


def test_a_call_that_led_to_a_command_at_each_of_its_places_is_not_missed():
    made = MADE | {(5, 13), (6, 13)}
    assert missed_calls(CELL.encode(), made, {"grip"}) == ()


def test_where_no_column_is_known_the_line_says():
    made = {(line, 0) for line in (3, 5, 6, 7, 10)}
    assert missed_calls(CELL.encode(), made, {"grip"}) == ()


def test_a_function_of_which_there_are_several_is_not_reported_by_its_name():
    twice = CELL + "\n\ndef grip(width):\n    pass\n"
    made = MADE - {(7, 16)}
    assert MissedCall(6, "self.grip") not in missed_calls(twice.encode(), made, {"grip"})


def test_a_source_that_is_no_python_misses_nothing():
    assert missed_calls(b"def (", MADE, {"grip"}) == ()


def test_the_call_that_makes_a_coroutine_misses_nothing_for_others_run_it():
    source = """\
async def routine(arm):
    arm.reach()

def main():
    loop.run_until_complete(routine(arm))
"""
    assert missed_calls(source.encode(), {(2, 5)}, {"routine"}) == ()
    as_function = source.replace("async ", "")
    assert missed_calls(as_function.encode(), {(2, 5)}, {"routine"}) == (MissedCall(5, "routine"),)
