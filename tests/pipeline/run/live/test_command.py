"""What may stand behind `--live --`, and what its environment becomes."""

import os
import signal
import subprocess
import sys
import time

import pytest

from tracerisk.errors import DependencyError, InputError
from tracerisk.pipeline.run.live.command import check_command, command_words
from tracerisk.ros.live.loopback import command_environment

HERE = {"PATH": os.defpath}
TREE = """
import os, subprocess, sys, time
from tracerisk.common.sandbox.kernel.features import adopt_orphans
from tracerisk.ros.live.process_tree import ProcessTree

adopt_orphans()
other = subprocess.Popen(["sleep", "60"])
# A shell that ends, of whose children one comes late, has left its session and hears no interrupt.
tree = ProcessTree(
    ["sh", "-c", "(trap '' INT; sleep 0.1; setsid sleep 60) & sleep 0.3"], os.environ, lambda: [other.pid]
)
while tree.code is None:
    tree.pids
    time.sleep(0.01)
time.sleep(0.1)
print(tree.code, len(tree.pids) > 0, other.pid in tree.pids)
tree.end()
print(tree.pids, other.poll())
other.kill()
"""


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ((), "is C or C\\+\\+, whose node is started by a command"),
        (("./pick", "__master:=http://10.0.0.1:11311"), "leave it out: a live run has its own"),
        (("./pick", "__ip:=10.0.0.1"), "__ip:=10.0.0.1 names where a node finds others"),
        (("./nothing",), "the program ./nothing of the command is not there; build it"),
        (("/",), "is there and cannot be executed"),
    ],
)
def test_what_starts_no_node_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        check_command(given, "pick.cpp", HERE, 1)


@pytest.mark.parametrize(
    ("name", "ros", "by", "remedy"),
    [
        ("cell.launch", 1, ("roslaunch",), "apt install python3-roslaunch"),
        ("cell.launch.py", 2, ("ros2", "launch"), "ros2, which starts launch files, is not in"),
        ("cell.launch.yaml", 2, ("ros2", "launch"), "source setup.bash of ROS"),
    ],
)
def test_a_launch_file_is_started_by_what_launches_it(tmp_path, name, ros, by, remedy):
    file = tmp_path / name
    file.write_text("<launch/>")
    given = (str(file), "speed:=2")
    assert command_words(given, ros) == (*by, *given)
    with pytest.raises(DependencyError, match=remedy):
        check_command(given, "pick.cpp", {"PATH": str(tmp_path)}, ros)


def test_nodes_have_the_environment_of_the_user_but_for_the_addresses():
    given = {
        "ROS_MASTER_URI": "http://192.0.2.1:11311",
        "ROS_IP": "192.0.2.2",
        "ROS_HOSTNAME": "robot",
        "ROS_PACKAGE_PATH": "/ws/src",
        "ROS_NAMESPACE": "/left",
        "LD_LIBRARY_PATH": "/ws/devel/lib",
    }
    made = command_environment(given, "http://127.0.0.1:4000")
    kept = ("ROS_PACKAGE_PATH", "ROS_NAMESPACE", "LD_LIBRARY_PATH")
    assert {name: made[name] for name in kept} == {name: given[name] for name in kept}
    assert made["ROS_MASTER_URI"] == "http://127.0.0.1:4000"
    assert made["ROS_IP"] == made["ROS_HOSTNAME"] == "127.0.0.1"


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="processes of Linux")
def test_orphans_of_a_command_belong_to_it_and_end_with_it():
    began = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-c", TREE], capture_output=True, text=True, check=True, timeout=50
    )
    assert done.stdout.splitlines() == ["0 True False", "() None"]
    assert time.monotonic() - began < 40
