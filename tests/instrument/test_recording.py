import os
from pathlib import Path

import pytest

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.traced.findings import Finding
from tracerisk.errors import Location, LogError
from tracerisk.instrument.commands import Command, traced_commands
from tracerisk.instrument.recorder import Recorder
from tracerisk.instrument.recording import Recording, read_recording
from tracerisk.instrument.source.python_source import FunctionSite
from tracerisk.instrument.tracer import Frame

MODULE = FunctionRef("c.py", QualifiedName("<module>"))
PICK = FunctionRef("c.py", QualifiedName("Node.pïck"))
STACK = (Frame(MODULE, 1, 1, (20, 1), "main"), Frame(PICK, 4, 2, (6, 9)))


def record(path: Path) -> Recording:
    now = [0]
    with path.open("wb") as stream:
        recorder = Recorder(stream, clock=lambda: now[0])
        recorder.note("robot", name="panda")
        recorder.function_ran(MODULE, 1)
        now[0] = 2_000_000
        first = recorder.command("trajectory", ["j1", "j2"], STACK)
        recorder.function_ran(PICK, 4)
        now[0] = 1_500_000_000
        recorder.command_ended(first, "arrived", way_done=1.0)
        recorder.command("gripper", ["hand"], STACK[:1])
        recorder.finding("planning", "out of reach", Location("c.py", 6, 9))
        recorder.run_ended("raised", "ValueError: no", Location("c.py", 7))
        recorder.run_ended("ended", "too late")
        recorder.note("objects", tube=[0.1, 0.2])
    return read_recording(path)


def test_what_was_recorded_is_read(tmp_path: Path) -> None:
    recording = record(tmp_path / "events.jsonl")
    assert recording.commands == (
        Command(1, "trajectory", ("j1", "j2"), STACK, 2_000_000, 1_500_000_000, "arrived", (), 1.0),
        Command(2, "gripper", ("hand",), STACK[:1], 1_500_000_000),
    )
    assert recording.functions_ran == (FunctionSite(MODULE, 1), FunctionSite(PICK, 4))
    assert recording.findings == (Finding("planning", "out of reach", 1.5, Location("c.py", 6, 9)),)
    assert recording.end is not None
    assert (recording.end.cause, recording.end.time_ns) == ("raised", 1_500_000_000)
    assert recording.end.location == Location("c.py", 7)
    assert recording.note("robot") == {"name": "panda"}
    assert recording.note("objects") == {"tube": [0.1, 0.2]}
    assert recording.note("scene") is None
    assert recording.last_ns == 1_500_000_000


def test_a_recording_cut_anywhere_gives_its_whole_lines(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    whole = record(path)
    content = path.read_bytes()
    for length in reversed(range(len(content))):
        os.truncate(path, length)
        cut = read_recording(path)
        whole_lines = [line for line in content[:length].split(b"\n") if line.endswith(b"}")]
        n_commands = sum(b'"event":"command",' in line for line in whole_lines)
        stacks = [command.stack for command in whole.commands]
        assert stacks[:n_commands] == [command.stack for command in cut.commands]
        assert cut.end in (None, whole.end)


def test_every_line_is_in_the_file_before_the_call_returns(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    with path.open("wb") as stream:
        Recorder(stream, clock=lambda: 5).function_ran(PICK, 4)
        assert read_recording(path).functions_ran == (FunctionSite(PICK, 4),)


@pytest.mark.parametrize("number", [float("nan"), float("inf"), float("-inf")])
def test_numbers_that_are_not_finite_are_recorded_by_their_names(tmp_path, number) -> None:
    path = tmp_path / "events.jsonl"
    with path.open("wb") as stream:
        recorder = Recorder(stream, clock=lambda: 0)
        for _ in range(2):
            recorder.failed("goal_rejected", "no", None, asker="a", target=[0.1, number])
        recorder.note("asked", fields={"pose": [1.0, {"x": number}]})
        recorder.run_ended("ended", "")
    recording = read_recording(path)
    (finding,) = recording.findings
    assert finding.target == ()
    assert recording.note("asked") == {"fields": {"pose": [1.0, {"x": str(number)}]}}


def test_an_empty_stack_is_refused(tmp_path: Path) -> None:
    with (tmp_path / "e").open("wb") as stream, pytest.raises(ValueError, match="at least one"):
        Recorder(stream, clock=lambda: 0).command("trajectory", ["j1"], ())


@pytest.mark.parametrize(
    "line", ["nonsense", '{"event":"dance","ns":1}', '{"event":"ran","ns":1,"function":7}', "[]"]
)
def test_a_damaged_line_before_the_last_is_an_error(tmp_path: Path, line: str) -> None:
    path = tmp_path / "events.jsonl"
    record(path)
    content = path.read_text().splitlines(keepends=True)
    path.write_text("".join([content[0], line + "\n", *content[1:]]))
    with pytest.raises(LogError, match=r"events.jsonl:2: not an event .*allowed: command,"):
        read_recording(path)


def test_a_missing_recording_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="cannot be read: No such file"):
        read_recording(tmp_path / "none.jsonl")


def test_what_runs_after_the_end_is_not_recorded(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    with path.open("wb") as stream:
        recorder = Recorder(stream, clock=lambda: 0)
        recorder.function_ran(MODULE, 1)
    recorder.function_ran(PICK, 4)
    assert read_recording(path).functions_ran == (FunctionSite(MODULE, 1),)


def test_what_replaced_a_command_and_what_was_refused_is_read(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    with path.open("wb") as stream:
        recorder = Recorder(stream, clock=lambda: 7)
        first = recorder.command("trajectory", ["j1"], STACK, goal=[0.5])
        second = recorder.command("trajectory", ["j1"], STACK, goal=[0.1])
        recorder.command_ended(first, "replaced", way_done=0.123456, replaced_by=second)
        recorder.refused("goal", "refused", STACK)
        recorder.command_ended(second, "arrived", goal=[0.2])
    recording = read_recording(path)
    one, two = recording.commands
    assert (one.end, one.way_done, one.replaced_by, one.goal) == ("replaced", 0.1235, 2, (0.5,))
    assert (two.end, two.way_done, two.replaced_by, two.goal) == ("arrived", None, None, (0.2,))
    assert [(each.kind, each.end, each.elements) for each in recording.refused] == [
        ("goal", "refused", ())
    ]
    traced = traced_commands(recording.commands, recording.refused)
    assert [(each.end, each.replaced_by) for each in traced] == [
        ("replaced", 1),
        ("arrived", None),
        ("refused", None),
    ]


@pytest.mark.parametrize("end", ['"gone"', "7", '"replaced","replaced_by":9'])
def test_an_end_that_there_is_not_is_an_error(tmp_path: Path, end: str) -> None:
    path = tmp_path / "events.jsonl"
    record(path)
    line = f'{{"event":"command_ended","ns":2000000000,"id":2,"end":{end}}}'
    path.write_text(path.read_text() + f"{line}\n" + '{"event":"note","ns":1}\n')
    with pytest.raises(LogError, match="not an event of a recording"):
        read_recording(path)
