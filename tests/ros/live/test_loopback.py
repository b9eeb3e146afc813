"""A live run has a network of its own, and what the host has set up decides nothing."""

import subprocess
import sys
import tempfile

import pytest

from tracerisk.errors import SandboxError
from tracerisk.pipeline.run.live import child
from tracerisk.ros.live import loopback
from tracerisk.ros.live.loopback import domain_environment, domain_of_run, loopback_environment

ALONE = """
import socket, sys
from tracerisk.common.sandbox.kernel.features import leave_network
from tracerisk.ros.live.loopback import interfaces
if not leave_network():
    print("not allowed"); sys.exit()
with socket.create_server(("127.0.0.1", 0)) as server:
    socket.create_connection(server.getsockname()).close()
try:
    socket.create_connection(("192.0.2.1", 11311), timeout=2.0)
    print("connected")
except OSError as error:
    print(",".join(interfaces()), type(error).__name__, error.errno)
"""
CONNECTION_REFUSED = 111


def test_variables_of_ros_are_replaced():
    given = {
        "ROS_MASTER_URI": "http://robot:11311",
        "ROS_IP": "192.168.0.2",
        "ROS_DOMAIN_ID": "7",
        "PYTHONPATH": "/somewhere",
        "HOME": "/home/user",
    }
    own = loopback_environment(given, "http://127.0.0.1:4000/")
    assert own["ROS_MASTER_URI"] == "http://127.0.0.1:4000/"
    assert own["ROS_IP"] == own["ROS_HOSTNAME"] == "127.0.0.1"
    assert own["HOME"] == "/home/user"
    assert not {"ROS_DOMAIN_ID", "PYTHONPATH"} & set(own)
    assert "ROS_MASTER_URI" not in loopback_environment(given)


def test_nothing_that_is_inherited_says_where_nodes_of_ros2_look_for_others():
    given = {
        "ROS_DISTRO": "jazzy",
        "ROS_DOMAIN_ID": "7",
        "ROS_DISCOVERY_SERVER": "robot:11811",
        "ROS_STATIC_PEERS": "robot",
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET",
        "FASTRTPS_DEFAULT_PROFILES_FILE": "/somewhere.xml",
        "FASTDDS_DEFAULT_PROFILES_FILE": "/somewhere.xml",
        "CYCLONEDDS_URI": "file:///somewhere.xml",
        "ZENOH_CONFIG_OVERRIDE": "connect",
        "RMW_IMPLEMENTATION": "rmw_zenoh_cpp",
        "PYTHONPATH": "/workspace",
        "PYTHONSTARTUP": "/somewhere.py",
        "AMENT_PREFIX_PATH": "/workspace",
        "LD_LIBRARY_PATH": "/workspace/lib",
    }
    assert domain_environment(given, 42) == {
        "ROS_DISTRO": "jazzy",
        "ROS_DOMAIN_ID": "42",
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_VERSION": "2",
        "SKIP_DEFAULT_XML": "1",
        "PYTHONUNBUFFERED": "1",
        "TZ": "UTC",
        "PYTHONPATH": "/workspace",
        "AMENT_PREFIX_PATH": "/workspace",
        "LD_LIBRARY_PATH": "/workspace/lib",
    }
    assert 1 <= domain_of_run() <= 100


def test_a_distribution_without_a_range_of_discovery_has_its_older_variable():
    own = domain_environment({"ROS_DISTRO": "humble"}, 3)
    assert own["ROS_LOCALHOST_ONLY"] == "1"
    assert "ROS_LOCALHOST_ONLY" not in domain_environment({}, 3)


def test_a_middleware_that_needs_no_router_is_kept():
    given = {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}
    assert domain_environment(given, 3)["RMW_IMPLEMENTATION"] == "rmw_cyclonedds_cpp"


def test_memory_is_shared_by_name_with_nobody():
    code = (
        "import os, sys\n"
        "from tracerisk.common.sandbox.kernel.features import leave_network\n"
        "print(leave_network(also_memory=True), os.listdir('/dev/shm'))\n"
    )
    with tempfile.NamedTemporaryFile(dir="/dev/shm"):
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
        )
    if done.stdout.startswith("False"):
        pytest.skip("the kernel allows no memory of its own here")
    assert done.stdout == "True []\n"


def test_nothing_but_loopback_is_left():
    done = subprocess.run(
        [sys.executable, "-c", ALONE], capture_output=True, text=True, check=True, timeout=60
    )
    if "not allowed" in done.stdout:
        pytest.skip("the kernel allows no network of its own here")
    assert done.stdout.split() == ["lo", "ConnectionRefusedError", str(CONNECTION_REFUSED)]


@pytest.mark.parametrize(
    ("may_leave", "interfaces", "is_alone"),
    [(True, ("eth0", "lo"), True), (False, ("lo",), True), (False, ("eth0", "lo"), False)],
)
def test_a_network_with_others_is_left_or_is_not_there(
    monkeypatch, may_leave, interfaces, is_alone
):
    monkeypatch.setattr(loopback, "leave_network", lambda *, also_memory: may_leave)
    monkeypatch.setattr(loopback, "interfaces", lambda: interfaces)
    assert loopback.leaves_others() == is_alone


def test_no_node_starts_on_a_network_with_others(monkeypatch, tmp_path):
    """It could name the master of a real robot by itself."""
    (tmp_path / "request.json").write_text("{}")
    monkeypatch.setattr(sys, "argv", ["child", str(tmp_path / "request.json")])
    monkeypatch.setattr(child.kernel, "adopt_orphans", lambda: None)
    monkeypatch.setattr(child.RunRequest, "loads", lambda text: text)
    monkeypatch.setattr(child, "leaves_others", lambda: False)
    monkeypatch.setattr(child, "recorded", lambda request, run: run(request, None, None))
    with pytest.raises(SandboxError, match="could move a real robot"):
        child.main()
