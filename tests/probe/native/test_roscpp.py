"""The preloaded probe in a node of the installed roscpp, beside a master."""

import json
import os
import subprocess
from pathlib import Path

import pytest

from tracerisk.errors import DependencyError
from tracerisk.ros.live.real_ros import python_of_ros

HERE = Path(__file__).parent
LIBRARIES = ["roscpp", "rosconsole", "roscpp_serialization", "rostime", "boost_system"]


@pytest.mark.skipif(not Path("/usr/include/ros/ros.h").is_file(), reason="no headers of roscpp")
def test_a_node_of_roscpp_is_recorded_with_its_callbacks(nodes):
    try:
        python = python_of_ros()
    except DependencyError as error:
        pytest.skip(str(error))
    program = nodes.folder / "roscpp"
    flags = ["-O1", "-g", "-fno-optimize-sibling-calls", *(f"-l{name}" for name in LIBRARIES)]
    subprocess.run(
        ["g++", str(HERE / "roscpp.cpp"), *flags, "-pthread", "-o", str(program)], check=True
    )
    changed = {"ROS_IP": "127.0.0.1", "ROS_HOME": str(nodes.folder)}
    env = {name: value for name, value in os.environ.items() if name != "ROS_HOSTNAME"}
    file = nodes.folder / "calls.jsonl"
    file.unlink(missing_ok=True)
    # Only a live run, which begins at some time, asks whether nothing is in progress.
    begins = "TRACERISK_TIME_BEGINS=1"
    preload = [f"LD_PRELOAD={nodes.library}", f"TRACERISK_CALLS={file}", begins]
    done = subprocess.run(
        [python, str(HERE / "with_master.py"), "env", *preload, str(program)],
        env={**env, **changed},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "called 0\n"), done.stderr
    log = nodes.log()
    assert log.notes == ()
    assert [
        (call.kind, call.name, call.seq, [frame.function for frame in call.stack])
        for call in log.calls
    ] == [
        ("publish", "/arm/command", 0, ["main", "Cell::swing"]),
        ("call", "/none", 0, ["main", "Cell::ask"]),
        ("end", "/none", 0, []),
        ("publish", "/arm/command", 1, ["Cell::on_timer", "Cell::swing"]),
        ("publish", "/arm/command", 2, ["main", "Cell::swing"]),
    ]
    entries = [json.loads(line) for line in file.read_text().replace("\0", "").split()]
    noted = {
        key: [entry[key] for entry in entries if key in entry] for key in ("spins", "calls_back")
    }
    # Two timers call back; what the first one sleeps is no wait of a loop.
    assert noted == {"spins": [1, 0], "calls_back": [1, 0, 1, 0]}
    # A thread sleeps, and waits on a condition and for a future.
    waits = [entry["kind"] for entry in entries if entry.get("kind") in ("wait", "waited")]
    assert waits == ["wait", "waited"] * 3
