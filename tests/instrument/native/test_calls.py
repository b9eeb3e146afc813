"""What the file of the preloaded probe says of functions, lines and gaps."""

import gc
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tracerisk.errors import InputError
from tracerisk.instrument.native.binaries import Binary, readers
from tracerisk.instrument.native.calls import Call, Frame, read_calls
from tracerisk.instrument.native.following import CallFollower

PROGRAM = """\
struct Cell { void home(); void swing(double); };
volatile double angle;
__attribute__((noinline)) void issue(double to) { angle = to; }
__attribute__((noinline)) void Cell::swing(double to) {
  issue(to);
  angle += 1;
}
__attribute__((always_inline)) inline void Cell::home() {
  swing(0.0);
  angle += 1;
}
int main() {
  Cell cell;
  cell.home();
  return 0;
}
"""
needs_compiler = pytest.mark.skipif(shutil.which("g++") is None, reason="no g++")


class Recorded:
    """A compiled program, and a file that says where it was."""

    def __init__(self, folder, *flags):
        self.file = folder / "calls.jsonl"
        self.source = folder / "cell.cpp"
        self.source.write_text(PROGRAM)
        self.program = folder / "cell"
        subprocess.run(
            ["g++", "-O1", "-no-pie", *flags, str(self.source), "-o", str(self.program)], check=True
        )
        code = subprocess.run(
            ["objdump", "-d", str(self.program)], check=True, capture_output=True, text=True
        ).stdout
        # The return address of the call of each function.
        self.at = {
            name: int(after, 16)
            for name, after in re.findall(r"call .*<(\w+)>\n +([0-9a-f]+):", code)
        }

    def write(self, *lines, **changed):
        there = self.program.stat()
        seen = {"size": there.st_size, "mtime": there.st_mtime_ns, **changed}
        module = [str(self.program), 0, 0x400000, 0x500000, seen["size"], seen["mtime"]]
        first = {"probe": 1, "pid": 7, "exe": str(self.program)}
        entries = [first, {"pid": 7, "map": 1, "modules": [module]}, *lines]
        self.file.write_text("".join(json.dumps(entry) + "\n" for entry in entries))
        return read_calls(self.file)

    def call(self, *at, **keys):
        issued = {"t": 5, "pid": 7, "tid": 8, "kind": "publish", "name": "/a", "seq": 0}
        return {**issued, "map": 1, "at": list(at), **keys}


@needs_compiler
def test_an_address_is_a_function_with_file_and_line_and_those_inlined_into_it(tmp_path):
    recorded = Recorded(tmp_path, "-g")
    log = recorded.write(
        recorded.call(recorded.at["_Z5issued"], recorded.at["_ZN4Cell5swingEd"], 0x7F0000)
    )
    source = str(recorded.source)
    stack = (
        Frame("main", source, 14),
        Frame("Cell::home", source, 9),
        Frame("Cell::swing", source, 5),
    )
    assert log.calls == (Call(5, 7, 8, "publish", "/a", 0, stack, False),)
    assert (log.programs, log.notes, log.newer) == ((str(recorded.program),), (), {})
    recorded.source.write_text("// A new first line.\n" + PROGRAM)
    log = recorded.write(recorded.call(recorded.at["_Z5issued"]))
    assert log.newer == {source: str(recorded.program)}


@needs_compiler
@pytest.mark.skipif(shutil.which("addr2line") is None, reason="no binutils")
def test_a_binary_names_all_its_sources_whether_or_not_they_ran(tmp_path):
    place = tmp_path / "place.cpp"
    place.write_text("#include <string>\nstd::string place() { return std::string(3, 'x'); }\n")
    recorded = Recorded(tmp_path, "-g", str(place))
    assert set(Binary(str(recorded.program)).sources()) >= {str(recorded.source), str(place)}
    recorded.write()
    follower = CallFollower(recorded.file)
    follower.new()
    assert {str(recorded.source), str(place)} <= set(follower.sources())
    recorded.program.unlink()
    assert follower.sources() == []


@needs_compiler
@pytest.mark.skipif(shutil.which("addr2line") is None, reason="no binutils")
def test_debug_information_is_read_once_however_often_and_for_how_much_it_is_asked(tmp_path):
    recorded = Recorded(tmp_path, "-g")
    before = set(readers())
    binary = Binary(str(recorded.program))
    address = recorded.at["_Z5issued"] - 1
    first = binary.places([address])
    (reader,) = set(readers()) - before
    many = binary.places([*range(address - 4, address + 3000), 2**40])
    assert many[address] == first[address] != ()
    assert many[2**40] == ()
    assert set(readers()) - before == {reader}
    del binary
    gc.collect()
    assert set(readers()) == before
    assert not Path(f"/proc/{reader}").exists()


@needs_compiler
@pytest.mark.skipif(shutil.which("addr2line") is None, reason="no binutils")
def test_a_folder_may_have_a_name_with_brackets(tmp_path):
    folder = tmp_path / "cell (discriminator)"
    folder.mkdir()
    recorded = Recorded(folder, "-g")
    log = recorded.write(recorded.call(recorded.at["_Z5issued"]))
    assert log.calls[0].stack == (Frame("Cell::swing", str(recorded.source), 5),)


@needs_compiler
@pytest.mark.parametrize("has_binutils", [True, False])
def test_a_program_without_lines_has_the_names_of_its_symbols(tmp_path, monkeypatch, has_binutils):
    recorded = Recorded(tmp_path)
    if not has_binutils:
        monkeypatch.setenv("PATH", str(tmp_path))
    log = recorded.write(recorded.call(recorded.at["_Z5issued"], recorded.at["_ZN4Cell5swingEd"]))
    assert log.calls[0].stack == (Frame("main", "", 0), Frame("Cell::swing", "", 0))
    (note,) = log.notes
    assert note.startswith(f"{recorded.program} has names but no lines: compile with -g ")


@needs_compiler
def test_a_program_without_symbols_names_nothing_and_says_which_flag_helps(tmp_path):
    recorded = Recorded(tmp_path, "-s")
    log = recorded.write(recorded.call(0x401140, 0x401150))
    assert log.calls[0].stack == ()
    (note,) = log.notes
    assert note.startswith(f"{recorded.program} has functions without names: compile with -g ")


@needs_compiler
def test_a_program_that_was_built_again_gives_no_names(tmp_path):
    recorded = Recorded(tmp_path, "-g")
    log = recorded.write(recorded.call(recorded.at["_Z5issued"]), mtime=1)
    assert log.calls[0].stack == ()
    assert "was built again after the run" in log.notes[0]


def test_a_resolved_stack_is_taken_as_it_is(tmp_path):
    file = tmp_path / "calls.jsonl"
    file.write_text(
        '{"t": 1, "tid": 2, "kind": "goal", "name": "/arm", "seq": 3, "stack": [["main", "a.cpp", 4]]}\n'
    )
    assert read_calls(file).calls == (
        Call(1, 0, 2, "goal", "/arm", 3, (Frame("main", "a.cpp", 4),), False),
    )


def test_space_that_no_process_used_is_passed_over_and_a_torn_line_told(tmp_path):
    file = tmp_path / "calls.jsonl"
    line = b'{"t": 1, "tid": 2, "kind": "call", "name": "/s", "seq": 0, "stack": []}\n'
    file.write_bytes(line + b"\0" * 999 + line + b'{"t": 1, "ti\n' + line + b"\0")
    log = read_calls(file)
    assert len(log.calls) == 3
    assert log.notes == (f"{file}: torn lines: 1; a process was killed while it wrote",)


def test_another_file_is_refused(tmp_path):
    file = tmp_path / "calls.jsonl"
    file.write_text('{"t": 1}\n')
    with pytest.raises(InputError, match=r"calls.jsonl:1: is no line of the probe"):
        read_calls(file)
    with pytest.raises(InputError, match="the probe writes the file that TRACERISK_CALLS names"):
        read_calls(tmp_path / "none")
