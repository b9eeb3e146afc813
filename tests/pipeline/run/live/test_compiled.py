"""Whose functions a compiled node's messages are: by what the probe wrote, lines and loops."""

import json
import time

import pytest

from tracerisk.errors import InputError
from tracerisk.pipeline.run.live.compiled import CompiledCalls, function_main

SOURCE = """\
namespace cell {
struct Cell {
  void swing();
  void home() { swing(); }
};
void Cell::swing()
{
  arm.sendGoal(goal);
}
void sweep()
{
  for (int i = 0; i < 3; ++i) {
    arm.sendGoal(goal);
  }
}
}  // namespace cell
void heard(const Message&) { pub.publish(stop); }
int main()
{
  cell::Cell cell;
  cell.home();
  for (;;) {
    cell.swing();
  }
}
"""
SWING, SWEEP, HOME = ("cell::Cell::swing", 8), ("cell::sweep", 13), ("cell::Cell::home", 4)
GOAL = "/arm/goal"


class Node:
    """What a probe writes of a node, and who reads it."""

    def __init__(self, folder):
        (folder / "pick.cpp").write_text(SOURCE)
        self.file, self.source = folder / "calls.jsonl", str(folder / "pick.cpp")
        self.counts, self.met, self.lines = {}, [], []
        self.calls = CompiledCalls(
            self.file, folder, "pick.cpp", lambda ref, line: self.met.append((ref.name, line)),
            lambda file, content: None,
        )  # fmt: skip

    def send(self, *stack, name=GOAL, tid=7, pid=7, file=None, kind="publish", of=0, t=1):
        """Note what a node sent with a stack of names and lines; return its number."""
        seq = self.counts.get((pid, name, of), 0)
        self.counts[pid, name, of] = seq + 1
        if kind == "publish" and name.endswith("/goal"):
            kind, name = "goal", name.removesuffix("/goal")
        frames = [[function, file or self.source, line] for function, line in stack]
        self.write(kind, name, seq, tid=tid, pid=pid, stack=frames, of=of, t=t)
        return seq

    def write(self, kind, name, seq, tid=7, pid=7, stack=(), of=0, t=1):
        entry = {"t": t, "pid": pid, "tid": tid, "kind": kind, "name": name, "seq": seq, "of": of}
        self.lines.append(json.dumps({**entry, "stack": stack}) + "\n")
        self.file.write_text("".join(self.lines))

    def note(self, line):
        """Note a state of the process, or that a thread waits: where, or no more."""
        if isinstance(line, dict):
            self.lines.append(json.dumps({"pid": 7, **line}) + "\n")
            self.file.write_text("".join(self.lines))
            return
        tid, *stack = line
        frames = [[function, self.source, at] for function, at in stack]
        self.write("wait" if stack else "waited", "", 0, tid=tid, stack=frames)

    def sent(self, *stack, **given):
        """Send, and return the functions to which it is ascribed, with their activations."""
        number = self.send(*stack, **given)
        return self.received(number, given.get("name", GOAL))

    def received(self, number, name=GOAL, at_ns=None):
        frames = self.calls.stack(name, number, at_ns)
        return [(frame.function.name, frame.site[0], frame.activation) for frame in frames]


@pytest.fixture
def node(tmp_path):
    return Node(tmp_path)


def activations(*stacks):
    return [[number for *_, number in stack] for stack in stacks]


def test_functions_have_the_names_and_lines_of_the_source(node):
    frames = node.sent(("main", 21), HOME, SWING)
    assert [(name, line) for name, line, _ in frames] == [("main", 21), HOME, SWING]
    assert node.met[-2:] == [("cell::Cell::home", 4), ("cell::Cell::swing", 6)]


def test_a_lambda_and_what_is_installed_belong_to_the_function_that_holds_them(node):
    frames = node.sent(("main", 21), ("main", 23))
    assert [(name, line) for name, line, _ in frames] == [("main", 21)]
    frames = node.sent(("main", 21), file="/usr/include/ros/publisher.h")
    assert [name for name, *_ in frames] == ["main"]
    assert node.calls.n_unknown == 1


def test_a_call_on_a_later_line_is_another_activation_of_the_same_caller(node):
    one, two = node.sent(("main", 21), SWING), node.sent(("main", 23), SWING)
    (main, swing), (also_main, other) = activations(one, two)
    assert main == also_main
    assert swing != other


def test_a_loop_of_the_callers_calls_anew(node):
    (main, swing), (also_main, other) = activations(
        *(node.sent(("main", 23), SWING) for _ in range(2))
    )
    assert main == also_main
    assert swing != other


def test_a_loop_of_the_function_itself_is_one_activation(node):
    one, two = (node.sent(("main", 23), SWEEP) for _ in range(2))
    assert activations(one) == activations(two)


def test_a_callback_of_a_thread_is_called_anew_each_time(node):
    one, two = (node.sent(("heard", 17), tid=9) for _ in range(2))
    assert one[0][2] != two[0][2]


def test_what_was_lost_before_it_reached_anybody_shifts_nothing(node):
    node.send(("main", 21), HOME, SWING)
    number = node.send(("main", 23), SWING)
    assert [name for name, *_ in node.received(number)] == ["main", "cell::Cell::swing"]
    # What is latched comes again, with the number that it had.
    assert [name for name, *_ in node.received(number)] == ["main", "cell::Cell::swing"]


def test_a_publisher_that_was_made_anew_counts_from_0_again(node):
    assert node.sent(("main", 21), HOME, SWING)[-1][:2] == SWING
    for stack in ([("main", 22), SWEEP], [("main", 23), SWING]):
        node.send(*stack)
        node.send(*stack)
        for number in (0, 1):
            assert [frame[:2] for frame in node.received(number)] == stack
    # Of the next one, the first was lost.
    for line in (21, 22, 23):
        node.send(("main", line))
    assert [[frame[1] for frame in node.received(number)] for number in (0, 2)] == [[21], [23]]


def test_of_two_publishers_of_a_topic_each_has_its_own_numbers(node):
    """Each loses messages, and their numbers alone say nothing: when they were sent does."""
    now_ns, began_ns = time.time_ns(), time.monotonic_ns()
    sent = []
    for turn in range(20):
        for of, stack in ((1, [("main", 21), HOME]), (2, [("main", 23), SWING])):
            t = began_ns + turn * 3_000_000 + of * 1_000_000
            number = node.send(*stack, name="/speed", of=of, t=t)
            sent.append((number, now_ns + t - began_ns + 30_000, stack))
    came = [sent[place] for place in range(len(sent)) if place % 5 not in (0, 3)]
    for number, at_ns, stack in came:
        assert [frame[:2] for frame in node.received(number, "/speed", at_ns)] == stack
    assert len({number for number, *_ in came}) < len(came)


def test_a_message_without_a_number_is_known_by_its_time(node):
    now_ns, began_ns = time.time_ns(), time.monotonic_ns()
    for place, stack in enumerate([[("main", 21), HOME], [("main", 23), SWING]]):
        node.send(*stack, name="/speed", t=began_ns + place * 1_000_000)
    frames = node.received(None, "/speed", now_ns + 1_000_000)
    assert [name for name, *_ in frames] == ["main", "cell::Cell::swing"]


def test_messages_without_a_header_are_taken_in_their_order_once_those_lost_are_forgotten(node):
    node.send(("main", 21), HOME, name="/speed")
    node.calls.settled()
    node.calls.settled()
    node.send(("main", 23), SWING, name="/speed")
    frames = node.received(None, "/speed")
    assert [name for name, *_ in frames] == ["main", "cell::Cell::swing"]


def test_a_call_of_a_service_that_reached_nobody_is_not_taken_for_the_next(node):
    lost = node.send(("main", 21), HOME, name="/ik", kind="call", tid=9)
    node.write("end", "/ik", lost, tid=9)
    node.send(("main", 23), SWING, name="/ik", kind="call")
    frames = node.received(None, "/ik")
    assert [name for name, *_ in frames] == ["main", "cell::Cell::swing"]


@pytest.mark.parametrize("file", ["../pick.cpp", "../../cell/pick.cpp", "cell/./pick.cpp"])
def test_a_source_is_found_by_its_name_from_the_folder_of_the_build(tmp_path, file):
    cell = tmp_path / "cell"
    cell.mkdir()
    (cell / "pick.cpp").write_text(SOURCE)
    calls = CompiledCalls(
        tmp_path / "calls", tmp_path, "cell/pick.cpp", lambda *_: None, lambda *_: None
    )
    assert calls.own_file(file) == "cell/pick.cpp"
    assert calls.own_file("../other.cpp") is None
    assert calls.own_file("") is None


MAIN, WORKER = 7, 9


@pytest.mark.parametrize(
    ("noted", "expected"),
    [
        ((), False),
        (({"spins": 1},), True),
        (({"spins": 1}, {"spins": 0}), False),
        (({"spins": 1}, {"calls_back": 1}), False),
        (({"spins": 1}, {"calls_back": 1}, {"calls_back": 0}), True),
        (((MAIN, ("main", 23)),), True),
        (((MAIN, ("main", 23)), (MAIN,)), True),  # between two of its waits
        (((MAIN, ("main", 23)), {"calls_back": 1}), False),
        (((MAIN, ("main", 21)),), False),
        (((MAIN, ("main", 21)), (MAIN,), {"spins": 1}), True),
        (({"spins": 1}, (WORKER, SWEEP)), False),
        (({"spins": 1}, (WORKER, SWEEP), (WORKER,)), True),
        (({"spins": 1}, (WORKER, ("main", 23), SWING)), True),
    ],
)
def test_a_node_only_waits_where_all_that_ends_by_itself_is_endless(node, noted, expected):
    for line in noted:
        node.note(line)
    assert node.calls.new_rounds() == []
    assert node.calls.only_wait(MAIN) is expected


@pytest.mark.parametrize(
    ("stacks", "n_rounds"),
    [
        ([[("main", 23)]] * 3, 2),
        ([[("main", 23)], [("main", 23), SWING]] * 3, 2),
        ([[("main", 21)]] * 3, 0),  # of no loop
        ([[("main", 23), SWEEP]] * 9, 0),  # of a loop within, which may still go on
    ],
)
def test_an_endless_loop_goes_round_where_it_comes_again_to_a_wait(node, stacks, n_rounds):
    for stack in stacks:
        node.note((MAIN, *stack))
    assert node.calls.new_rounds() == [(MAIN, ("pick.cpp", 22))] * n_rounds


def test_what_nobody_saw_belongs_to_main_and_is_counted(node):
    assert [(name, line) for name, line, _ in node.received(0)] == [("main", 18)]
    assert (node.calls.n_known, node.calls.n_unknown) == (0, 1)
    assert not node.calls.has_reported


def test_a_source_without_main_is_refused():
    with pytest.raises(InputError, match=r"has no main\(\); name the source in which the node"):
        function_main(b"void pick() {}\n", "pick.cpp")
