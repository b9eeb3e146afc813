"""What is recorded of compiled nodes whose functions are not known, and of how they end."""

import json
import os
import subprocess
from types import SimpleNamespace

import pytest

from tracerisk.errors import DependencyError
from tracerisk.instrument.recorder import Recorder
from tracerisk.pipeline.run.live.nodes import CompiledNodes


@pytest.fixture
def made(tmp_path, monkeypatch):
    """Nodes for which no compiler makes the probe, and what reads their recording."""
    monkeypatch.setenv("CC", "no-such-compiler")
    source = tmp_path / "pick.cpp"
    source.write_text("int main() { return 0; }\n")
    files = {"controller": str(source), "root": str(tmp_path)}
    request = SimpleNamespace(argv=("./pick",), answers=(), **files)
    with (tmp_path / "events.jsonl").open("wb", buffering=0) as stream:
        nodes = CompiledNodes(request, Recorder(stream, clock=lambda: 0), tmp_path, {}, 1)

        def recorded(event):
            lines = (tmp_path / "events.jsonl").read_text().splitlines()
            return [entry for entry in map(json.loads, lines) if entry["event"] == event]

        yield nodes, recorded


def test_without_a_probe_everything_is_assumed_to_be_of_main(made):
    nodes, recorded = made
    (frame,) = nodes.sender("/speed", b"", None)
    assert (frame.function.name, frame.line, frame.root) == ("main", 1, "main")
    nodes.report_attribution()
    (finding,) = recorded("finding")
    assert (finding["kind"], finding["object"]) == ("functions_assumed", "main")
    assert finding["message"].startswith(
        "functions: 1 of 1 messages and calls count as those of main(): no probe was loaded into "
        "the nodes: the compiler no-such-compiler cannot be run"
    )


def test_a_source_that_sent_nothing_is_read_for_what_it_could_have_sent(made, tmp_path):
    nodes, recorded = made
    (tmp_path / "place.cpp").write_text("void place() { arm.sendGoal(goal); }\n")
    (tmp_path / "binary.so").write_bytes(b"")
    files = [str(tmp_path / name) for name in ("place.cpp", "binary.so", "gone.cpp")]
    nodes._calls._follower.sources = lambda: [*files, "/usr/include/c++/12/string"]
    nodes.report_attribution()
    assert [event["file"] for event in recorded("source")] == ["pick.cpp", "place.cpp"]


def test_a_source_that_changed_after_the_build_is_no_source_of_what_ran(made, tmp_path):
    nodes, recorded = made
    nodes._calls._follower.newer = {
        str(tmp_path / "pick.cpp"): "/ws/pick",
        "/elsewhere/util.h": "/ws/pick",
    }
    nodes.report_attribution()
    (finding,) = recorded("finding")
    assert (finding["kind"], finding["object"]) == ("functions_assumed", "pick.cpp")
    assert finding["message"] == (
        "functions: pick.cpp has changed since /ws/pick was built from it, so that other code ran "
        "than it has now: build it again"
    )


def test_a_folder_that_the_loader_cannot_name_is_told(made, tmp_path, monkeypatch):
    nodes, recorded = made
    folder = tmp_path / "of a user"
    folder.mkdir()
    source = str(tmp_path / "pick.cpp")
    request = SimpleNamespace(argv=("./pick",), answers=(), controller=source, root=str(tmp_path))
    nodes = CompiledNodes(request, nodes._recorder, folder, {}, 1)
    nodes.sender("/speed", b"", None)
    nodes.report_attribution()
    (finding,) = recorded("finding")
    assert "LD_PRELOAD cannot name the folder" in finding["message"]
    assert "set TMPDIR to another" in finding["message"]


def test_nodes_of_ros2_are_not_started_without_the_probe(made, tmp_path):
    source = str(tmp_path / "pick.cpp")
    request = SimpleNamespace(argv=("./pick",), answers=(), controller=source, root=str(tmp_path))
    with pytest.raises(DependencyError, match="the compiler no-such-compiler cannot be run"):
        CompiledNodes(request, made[0]._recorder, tmp_path, {}, 2)


def test_nodes_of_ros2_get_parameters_and_simulated_time(made, tmp_path, monkeypatch):
    monkeypatch.delenv("CC")
    monkeypatch.setattr("tracerisk.pipeline.run.live.nodes.build_probe", lambda folder: folder)
    source, begun = str(tmp_path / "pick.cpp"), []
    request = SimpleNamespace(argv=("./pick",), answers=(), controller=source, root=str(tmp_path))
    nodes = CompiledNodes(request, made[0]._recorder, tmp_path, {"HOME": "/root"}, 2)
    nodes.begin(SimpleNamespace(begin_command=begun.append), "/run/parameters.yaml")
    (command,) = begun
    assert command.environment["TRACERISK_ROS_ARGUMENTS"].split("\n") == [
        *("--ros-args", "--params-file", "/run/parameters.yaml", "-p", "use_sim_time:=true", "--")
    ]
    assert command.environment["HOME"] == "/root"


def test_a_node_of_ros2_that_has_made_something_has_come(made, tmp_path, monkeypatch):
    monkeypatch.setattr("tracerisk.pipeline.run.live.nodes.build_probe", lambda folder: folder)
    source = str(tmp_path / "pick.cpp")
    request = SimpleNamespace(argv=("./pick",), answers=(), controller=source, root=str(tmp_path))
    nodes = CompiledNodes(request, made[0]._recorder, tmp_path, {}, 2)
    assert nodes.is_awaited
    line = {"pid": 7, "made": "client", "name": "/grip", "node": "/cell"}
    type_name = ["std_srvs::srv", "SetBool"]
    (tmp_path / "calls.jsonl").write_text(json.dumps({**line, "type": type_name}) + "\n")
    assert nodes.new_ends() == [
        {"is": "service_client", "name": "/grip", "type": "std_srvs/SetBool"}
    ]
    assert not nodes.is_awaited
    assert nodes.new_ends() == []


def test_what_a_crashed_node_of_ros2_published_is_gone_once_nothing_is_under_way(
    made, tmp_path, monkeypatch
):
    monkeypatch.setattr("tracerisk.pipeline.run.live.nodes.build_probe", lambda folder: folder)
    source = str(tmp_path / "pick.cpp")
    request = SimpleNamespace(argv=("./pick",), answers=(), controller=source, root=str(tmp_path))
    nodes = CompiledNodes(request, made[0]._recorder, tmp_path, {}, 2)
    with subprocess.Popen(["sleep", "600"]) as process:
        line = {"pid": process.pid, "made": "publisher", "name": "/speed", "node": "/cell"}
        line |= {"type": ["std_msgs::msg", "Float64"], "reliable": 1, "kept": 0}
        (tmp_path / "calls.jsonl").write_text(json.dumps(line) + "\n")
        assert [frame["is"] for frame in nodes.new_ends()] == ["publisher"]
        nodes.settled()
        assert nodes.new_ends() == []
        process.kill()
    assert nodes.new_ends() == []
    nodes.settled()
    assert nodes.new_ends() == [{"is": "no_publisher", "name": "/speed", "caller": "/cell"}]


def test_what_has_no_known_type_is_told(made, tmp_path, monkeypatch):
    monkeypatch.setattr("tracerisk.pipeline.run.live.nodes.build_probe", lambda folder: folder)
    source = str(tmp_path / "pick.cpp")
    request = SimpleNamespace(argv=("./pick",), answers=(), controller=source, root=str(tmp_path))
    nodes = CompiledNodes(request, made[0]._recorder, tmp_path, {}, 2)
    line = {"pid": 7, "made": "publisher", "name": "/arm/command", "node": "/cell"}
    line |= {"type": ["", ""], "reliable": 1, "kept": 0}
    (tmp_path / "calls.jsonl").write_text(json.dumps(line) + "\n")
    assert nodes.new_ends() == []
    nodes.report_attribution()
    (finding,) = made[1]("finding")
    assert (finding["kind"], finding["object"]) == ("not_simulated", "/arm/command")
    assert finding["message"] == (
        "what /cell exchanges on /arm/command does not reach the twin, for its type is not known: "
        "build the package of the type with rosidl_default_generators, and source the setup of its "
        "workspace"
    )


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"exit": 0}, None),
        ({"exit": 3}, ("exited", "/ws/pick ended with code 3")),
        ({}, ("died", "/ws/pick was ended by a signal, as by a crash, or by _exit()")),
        ({"exe": "/opt/ros/noetic/lib/rosout/rosout"}, None),
        ({"forked": 1}, None),
        ({"lives": True}, None),
    ],
)
def test_a_node_that_another_program_started_and_that_crashed_is_no_good_end(
    made, tmp_path, given, expected
):
    nodes, _ = made
    pid = os.getpid() if given.get("lives") else 2**22 + 1  # Linux numbers none so
    head = {"probe": 1, "pid": pid, "exe": given.get("exe", "/ws/pick")}
    if "forked" in given:
        head["forked"] = 1
    lines = [head, *([{"pid": pid, "exit": given["exit"]}] if "exit" in given else [])]
    (tmp_path / "calls.jsonl").write_text("".join(f"{json.dumps(line)}\n" for line in lines))
    assert nodes.bad_end() == expected


@pytest.mark.parametrize(
    ("code", "cause", "message"),
    [
        (0, "ended", "./pick ended"),
        (3, "exited", "./pick ended with code 3; no node of it has registered with the run's"),
        (-11, "died", "./pick was ended by SIGSEGV"),
        (-40, "died", "./pick was ended by signal 40"),
    ],
)
def test_the_end_of_the_command_is_that_of_the_run(made, code, cause, message):
    nodes, recorded = made
    nodes.report_end(code)
    (end,) = recorded("end")
    assert end["cause"] == cause
    assert end["message"].startswith(message)
