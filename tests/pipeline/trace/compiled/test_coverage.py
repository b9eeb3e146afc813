"""Which functions of a compiled controller can command, and which of them did."""

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.instrument.commands import Command
from tracerisk.instrument.recording import Recording
from tracerisk.instrument.tracer import Frame
from tracerisk.pipeline.trace.compiled.coverage import c_coverage

SOURCE = b"""\
void Cell::send(double to) { pub_.publish(message(to)); }
void Cell::pick() { send(0.5); }
void Cell::park() { if (late) { pick(); } }
void Cell::show() { markers_.publish(marker()); }
void Cell::look() { show(); }
void Cell::grasp() { hand_->sendGoal(goal()); }
int main() { Cell cell; run([&]() { cell.pick(); }); }
"""


def command(*stack):
    frames = tuple(
        Frame(FunctionRef("pick.cpp", QualifiedName(name)), line, 1, (line, 0))
        for name, line in stack
    )
    return Command(1, "trajectory", ("joint1",), frames, 0)


def test_what_can_command_and_did_not_never_ran():
    stack = (("main", 7), ("Cell::pick", 2), ("Cell::send", 1))
    coverage = c_coverage(Recording(commands=(command(*stack),), sources={"pick.cpp": SOURCE}))
    assert [(item.ref.name, item.line) for item in coverage.never_ran] == [
        ("Cell::park", 3),
        ("Cell::grasp", 6),
    ]
    assert (coverage.ran, coverage.all) == (3, 5)


def test_without_a_command_names_of_calls_must_do():
    coverage = c_coverage(Recording(sources={"pick.cpp": SOURCE}))
    assert [item.ref.name for item in coverage.never_ran] == ["Cell::grasp"]
