"""What the preloaded probe records of a compiled node, however it ends, and what it leaves alone."""

import json
import shutil
import signal
import subprocess
from collections import Counter
from pathlib import Path

import pytest

from tracerisk.errors import DependencyError
from tracerisk.instrument.native.calls import read_calls
from tracerisk.instrument.native.following import CallFollower
from tracerisk.instrument.native.library import build_probe

THROUGH = """\
#include "ros.h"
extern "C" void through(void (*call)());
static ros::Publisher arm("/arm/command", "std_msgs/Float64");
static void send() { arm.publish(1); }
int main() { through(send); return 0; }
"""
HOME = ["main", "Cell::home", "Cell::swing"]


def stacks(log):
    return [[frame.function for frame in call.stack] for call in log.calls]


def test_each_kind_of_command_has_its_name_number_and_functions(nodes, node):
    assert nodes.run(node, "kinds").stdout == "kinds 4\n"
    log = nodes.log()
    assert [(call.kind, call.name, call.seq) for call in log.calls] == [
        ("publish", "/arm/command", 0),
        ("goal", "/arm", 0),
        ("call", "/gripper/set", 0),
        ("end", "/gripper/set", 0),
        ("publish", "/move_base_simple/goal", 0),  # a plain topic, by its type
    ]
    assert stacks(log) == [HOME, ["main", "Cell::reach"], ["main", "Cell::grip"], [], ["main"]]
    place = log.calls[0].stack[2]
    text = Path(place.file).read_text().splitlines()
    assert text[place.line - 1].strip() == "arm_.publish(angle);"
    times = [call.t_ns for call in log.calls]
    assert times == sorted(times)
    assert (log.programs, log.notes) == ((str(node),), ())


WAYS = {
    "return": 0,
    "exit": 3,
    "_exit": 4,
    "quick": 5,
    "abort": -signal.SIGABRT,
    "terminate": -signal.SIGABRT,
    "segv": -signal.SIGSEGV,
    "kill": -signal.SIGKILL,
    "term": -signal.SIGTERM,
    "int": -signal.SIGINT,
}


@pytest.mark.slow(but=5)
@pytest.mark.parametrize("way", WAYS)
def test_nothing_is_lost_however_a_node_ends(nodes, node, way):
    assert nodes.run(node, way, "700").returncode == WAYS[way]
    log = nodes.log()
    assert [call.seq for call in log.calls] == list(range(700))
    assert all(stack == HOME for stack in stacks(log))
    assert log.notes == ()
    follower = CallFollower(nodes.folder / "calls.jsonl")
    follower.new()
    assert list(follower.own_processes.values()) == [str(node)]
    # A process ends by itself, and says how, or is ended.
    assert list(follower.codes.values()) == ([WAYS[way]] if way in ("return", "exit") else [])


def test_a_node_that_executes_another_program_loses_nothing(nodes, node):
    assert nodes.run(node, "exec", "2").returncode == 0
    log = nodes.log()
    assert [call.seq for call in log.calls] == [0, 1, 0]
    assert stacks(log) == [HOME] * 3
    assert len({call.pid for call in log.calls}) == 1


def test_a_forked_process_goes_on_as_its_own(nodes, node):
    assert nodes.run(node, "fork").returncode == 0
    log = nodes.log()
    pids = list(dict.fromkeys(call.pid for call in log.calls))
    by_pid = [[(c.kind, c.seq) for c in log.calls if c.pid == pid] for pid in pids]
    assert sorted(by_pid) == [[("publish", 0), ("goal", 0)], [("publish", 0), ("publish", 1)]]
    assert stacks(log)[-1][0] == "main"


def test_exceptions_pass_the_probe_and_end_their_call(nodes, node):
    assert nodes.run(node, "throw").stdout == "caught 3\n"
    kinds = [call.kind for call in nodes.log().calls]
    assert kinds == ["publish", "call", "end", "publish"]


def test_sixteen_threads_at_once_lose_nothing(nodes, node):
    assert nodes.run(node, "threads", "500").stdout == "joined 8000\n"
    log = nodes.log()
    assert [call.seq for call in log.calls] == list(range(8000))
    assert Counter(Counter(call.tid for call in log.calls).values()) == {500: 16}
    # A lambda is a part of the function in which it stands.
    assert all(stack == HOME for stack in stacks(log))
    times = [call.t_ns for call in log.calls]
    assert times == sorted(times)


def test_a_handler_of_a_signal_that_publishes_hangs_nothing(nodes, node):
    done = nodes.run(node, "handler", "50000")
    assert done.stdout.startswith("handled ")
    assert len(nodes.log().calls) >= 50000


@pytest.mark.parametrize(("depth", "is_cut"), [(0, False), (200, False), (5000, True)])
def test_a_deep_stack_is_cut_at_its_outer_end_and_said_to_be(nodes, node, depth, is_cut):
    assert nodes.run(node, "deep", str(depth)).returncode == 0
    (call,) = nodes.log().calls
    names = [frame.function for frame in call.stack]
    assert call.is_cut == is_cut
    assert (names[0] == "main") == (not is_cut)
    assert names[-3:] == ["dive", "Cell::home", "Cell::swing"]
    assert names.count("dive") == depth + 1 or is_cut


def test_the_functions_of_rcl_are_recorded_and_answer_as_before(nodes, node):
    assert nodes.run(node, "ros2").returncode == 0
    assert [(call.kind, call.name, call.seq) for call in nodes.log().calls] == [
        ("publish", "/arm/command", 0),
        ("publish", "/arm/command", 1),
        ("publish", "/arm/command", 2),
        ("call", "/gripper/set", 0),
        ("goal", "/cell/arm/move", 0),  # not its service once more
    ]


def test_messages_of_rcl_are_counted_for_each_publisher_of_a_topic(nodes, node):
    assert nodes.run(node, "publishers").returncode == 0
    numbers = [(call.of, call.seq) for call in nodes.log().calls]
    # The last one is another, at the place of the first.
    assert numbers == [(1, 0), (2, 0), (2, 1), (1, 1), (3, 0)]


def test_what_a_node_of_rcl_makes_and_gives_up_is_noted(nodes, node):
    assert nodes.run(node, "ends").returncode == 0
    follower = CallFollower(nodes.folder / "calls.jsonl")
    assert follower.new() == []
    pid = follower.ends[0]["pid"]
    of = {"pid": pid, "node": "/cell"}
    typed = {**of, "type": ["std_msgs::msg", "Float64"]}
    assert follower.ends == [
        {**typed, "made": "publisher", "name": "/speed", "reliable": 0, "kept": 1},
        {**typed, "made": "subscription", "name": "/states", "reliable": 1, "kept": 0},
        {**typed, "made": "client", "name": "/grip"},
        {**typed, "made": "service", "name": "/stop"},
        # Not what rcl refused.
        {**of, "type": ["", ""], "made": "publisher", "name": "/unknown", "reliable": 0, "kept": 1},
        {**of, "gone": "publisher", "name": "/speed"},
    ]
    assert nodes.log().calls == ()


def test_libraries_of_ros2_are_none_of_the_node_wherever_they_were_built(nodes, tmp_path):
    (tmp_path / "node.cpp").write_text(THROUGH)
    (tmp_path / "through.cpp").write_text('extern "C" void through(void (*call)()) { call(); }\n')
    recorded = {}
    for name in ("librclcpp.so", "librclcpp_cell.so"):
        library = nodes.folder / name
        subprocess.run(
            ["g++", "-fPIC", "-shared", str(tmp_path / "through.cpp"), "-o", str(library)],
            check=True,
        )
        sources = [tmp_path / "node.cpp", library]
        program = nodes.compile("-g", source=sources, name="through")
        assert nodes.run(program).returncode == 0
        log = nodes.log()
        recorded[name] = (stacks(log), any(name in note for note in log.notes))
    assert recorded == {
        "librclcpp.so": ([["main", "send"]], False),
        "librclcpp_cell.so": ([["main", "through", "send"]], True),
    }


def test_only_a_run_gives_arguments_to_nodes(nodes, node, monkeypatch):
    done = nodes.run(node, "arguments")
    assert (done.stdout, done.returncode) == ("2 node;left; 1\n", 0)
    monkeypatch.setenv("TRACERISK_ROS_ARGUMENTS", "--ros-args\n-p\nuse_sim_time:=true")
    done = nodes.run(node, "arguments")
    words = "node;left;--ros-args;-p;use_sim_time:=true;"
    assert (done.stdout, done.returncode) == (f"5 {words} 0\n", 3)


def test_a_node_that_closes_all_files_is_recorded_to_its_end(nodes, node):
    assert nodes.run(node, "closes").stdout == "closed 2000\n"
    assert len(nodes.log().calls) == 2000


def test_several_nodes_write_to_one_file(nodes, node):
    nodes.run(node, "return", "3")
    # What somebody else has written there ends in the middle of a page.
    nodes.run(node, "return", "900", fresh=False)
    assert [call.seq for call in nodes.log().calls] == [*range(3), *range(900)]


def test_a_program_without_ros_and_a_run_without_a_file_write_nothing(nodes, node):
    shell = shutil.which("true")
    assert nodes.run(shell).returncode == 0
    assert not (nodes.folder / "calls.jsonl").exists()


def told_once(done, problem):
    lines = done.stderr.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("tracerisk: ")
    assert problem in lines[0]
    assert lines[0].split("; ")[1].startswith("no further command of process ")


def test_a_file_that_cannot_be_written_is_told_once_and_the_node_goes_on(nodes, node):
    done = nodes.run(node, "return", "500", to="none/calls.jsonl")
    assert (done.returncode, done.stdout) == (0, "returns 500\n")
    told_once(done, "none/calls.jsonl: cannot be opened: No such file or directory")


@pytest.mark.parametrize("device", ["/dev/full", "/dev/null"])
def test_a_device_is_refused(nodes, node, device):
    done = nodes.run(node, "return", "5", to=device, fresh=False)
    assert done.returncode == 0
    told_once(done, f"{device}: is no regular file")


def test_a_file_that_may_not_grow_is_told_once_and_keeps_what_it_has(nodes, node):
    prlimit = shutil.which("prlimit")
    if prlimit is None:
        pytest.skip("no prlimit")
    done = nodes.run(node, "return", "5000", before=(prlimit, "--fsize=150000"))
    assert (done.returncode, done.stdout) == (0, "returns 5000\n")
    told_once(done, "cannot grow")
    calls = nodes.log().calls
    assert [call.seq for call in calls] == list(range(len(calls)))
    assert 400 < len(calls) < 5000


def test_a_full_disk_is_told_once_and_the_node_goes_on(nodes, node, tmp_path):
    mounted = tmp_path / "small"
    mounted.mkdir()
    file, kept = mounted / "calls.jsonl", tmp_path / "kept.jsonl"
    inner = (
        f"mount -t tmpfs -o size=192k none {mounted} || exit 77\n"
        f"LD_PRELOAD={nodes.library} TRACERISK_CALLS={file} {node} return 5000\n"
        f"code=$?; cp {file} {kept}; exit $code"
    )
    unshare = shutil.which("unshare")
    if unshare is None:
        pytest.skip("no unshare")
    done = subprocess.run(
        [unshare, "-rm", "sh", "-c", inner], capture_output=True, text=True, check=False
    )
    if done.returncode == 77 or "unshare" in done.stderr:
        pytest.skip("no file system can be mounted")
    assert (done.returncode, done.stdout) == (0, "returns 5000\n")
    told_once(done, "cannot grow: No space left on device")
    calls = read_calls(kept).calls
    assert [call.seq for call in calls] == list(range(len(calls)))
    assert len(calls) > 300


def test_a_file_that_is_cut_off_does_not_end_the_node(nodes, node):
    done = nodes.run(node, "truncate")
    assert (done.returncode, done.stdout) == (0, "went on 2\n")
    told_once(done, "was cut off by another program")


FLAGS = {
    "-O0": ["-fno-omit-frame-pointer", "-fPIE", "-pie"],
    "-O1": ["-fomit-frame-pointer", "-fno-pie", "-no-pie"],
    "-O2": ["-fomit-frame-pointer", "-fPIE", "-pie"],
    "-O3": ["-fno-omit-frame-pointer", "-fno-pie", "-no-pie"],
    "-Os": ["-fomit-frame-pointer", "-flto", "-fPIE", "-pie"],
}


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("level", FLAGS)
@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_stacks_are_the_same_by_every_compiler_and_level(nodes, compiler, level):
    program = nodes.compile(level, *FLAGS[level], "-g", compiler=compiler, name="other")
    assert nodes.run(program, "kinds").stdout == "kinds 4\n"
    log = nodes.log()
    assert stacks(log) == [HOME, ["main", "Cell::reach"], ["main", "Cell::grip"], [], ["main"]]
    assert log.notes == ()
    assert nodes.run(program, "threads", "20").stdout == "joined 320\n"
    assert all(stack == HOME for stack in stacks(nodes.log()))
    assert nodes.run(program, "throw").stdout == "caught 3\n"


def test_a_stripped_program_is_recorded_and_told_which_flag_helps(nodes):
    program = nodes.compile("-O2", "-s", name="stripped")
    nodes.run(program, "kinds")
    log = nodes.log()
    assert [call.kind for call in log.calls] == ["publish", "goal", "call", "end", "publish"]
    assert any("compile with -g" in note for note in log.notes)


def test_a_statically_linked_program_never_reports(nodes):
    source = nodes.folder / "static.cpp"
    source.write_text("int main() { return 0; }\n")
    program = nodes.folder / "static"
    nodes._compile("g++", ["-static-pie", str(source)], program)
    assert nodes.run(program).returncode == 0
    assert not (nodes.folder / "calls.jsonl").exists()


def test_the_file_is_lines_of_json(nodes, node):
    nodes.run(node, "return")
    data = (nodes.folder / "calls.jsonl").read_bytes().replace(b"\0", b"").strip()
    begin, modules, call, end = map(json.loads, data.splitlines())
    assert begin == {"probe": 1, "pid": call["pid"], "exe": str(node)}
    assert modules["modules"][0][0] == str(node)
    assert end == {"pid": call["pid"], "exit": 0}
    assert list(call) == ["t", "pid", "tid", "kind", "name", "seq", "map", "at"]


def test_a_compiler_that_fails_is_named(tmp_path, monkeypatch):
    for compiler, problem in (
        ("false", "the compiler false failed: it ended with 1"),
        ("no-such-compiler", "no-such-compiler cannot be run"),
    ):
        monkeypatch.setenv("CC", compiler)
        with pytest.raises(DependencyError, match=problem):
            build_probe(tmp_path)
    monkeypatch.delenv("CC")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(DependencyError, match="there is none of cc, gcc, clang; install one"):
        build_probe(tmp_path)


def test_no_file_stays_open(nodes, node):
    """A node may count on the next number."""
    prlimit = shutil.which("prlimit")
    if prlimit is None:
        pytest.skip("no prlimit")
    assert nodes.run(node, "return", "3000", before=(prlimit, "--nofile=5")).returncode == 0
    assert len(nodes.log().calls) == 3000
