"""Programs on real rclpy with the twin as a node: they do what they do on the stand-ins."""

import re
import socket
import subprocess
import tempfile
import threading
from pathlib import Path

import pytest

from tests.ros.live.test_differential import assert_same, logged
from tracerisk import api

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("real_rclpy")]

PROGRAMS = Path(__file__).parent / "programs"
CODES = {"callback-raised": 1, "thread-raised": 1, "error-logged": 1, "call-raised": 1}
DISCOVERY_PORT = 11811
PROFILE = """<?xml version="1.0"?>
<profiles xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">
  <participant profile_name="away" is_default_profile="true"><rtps><builtin>
    <initialPeersList><locator><udpv4><address>127.0.0.1</address><port>{port}</port></udpv4>
    </locator></initialPeersList>
  </builtin></rtps></participant>
</profiles>
"""


def traced(folder, name, capfd, live_speed, **given):
    (folder / "pyproject.toml").touch()
    script = folder / f"{name}.py"
    script.write_bytes((PROGRAMS / script.name).read_bytes())
    controller = api.load_controller(script)
    settings = api.load_settings(
        controller, {"robot": "panda", "draft": False, "ros_distro": "jazzy", **given}
    )
    trace = api.trace_controller(controller, settings, live_speed=live_speed)
    return trace, "".join(capfd.readouterr())


def skip_without(python, package):
    asked = subprocess.run([python, "-c", f"import {package}.action"], capture_output=True)
    if asked.returncode:
        pytest.skip(f"the installed ROS 2 has no {package}")


@pytest.mark.parametrize("name", ["awaited", "callbacks", "topics_and_services"])
def test_a_program_does_the_same_under_real_rclpy(name, tmp_path, capfd):
    live, printed = traced(tmp_path, name, capfd, 1.0)
    twin, also_printed = traced(tmp_path, name, capfd, None)
    lines = logged(also_printed)
    assert lines, "the program printed nothing to compare"
    assert logged(printed) == lines
    # Where a motion is cut short, or another follows it, depends on when the message comes.
    assert_same(live, twin, near=0.05)
    assert live.verdict.kind == twin.verdict.kind
    assert any("rclpy" in line for line in live.assumptions)


def test_move_group_is_served_with_its_kinematics_and_scene(tmp_path, capfd, real_rclpy):
    skip_without(real_rclpy, "moveit_msgs")
    live, printed = traced(tmp_path, "move_group", capfd, 1.0)
    twin, also_printed = traced(tmp_path, "move_group", capfd, None)
    assert logged(printed) == logged(also_printed)
    assert len(logged(printed)) == 10
    assert_same(live, twin, near=0.05)
    assert live.verdict.kind == twin.verdict.kind == "faulted"
    (reason,) = (reason for reason in live.verdict.reasons if reason.code not in CODES)
    assert "NO_IK_SOLUTION" in reason.message


def test_what_fails_is_said_as_on_the_stand_ins(tmp_path, capfd, real_rclpy):
    skip_without(real_rclpy, "example_interfaces")
    live, printed = traced(tmp_path, "failing", capfd, 1.0)
    twin, also_printed = traced(tmp_path, "failing", capfd, None)
    assert logged(printed) == logged(also_printed)

    def reasons(trace):
        return sorted(
            (reason.code, reason.message, reason.location and reason.location.line)
            for reason in trace.verdict.reasons
            if reason.code in CODES
        )

    assert reasons(live) == reasons(twin)
    codes = [code for code, *_ in reasons(live)]
    assert {code: codes.count(code) for code in codes} == CODES
    assert live.verdict.kind == twin.verdict.kind == "faulted"


def test_parameters_reach_the_node(tmp_path, capfd):
    (tmp_path / "limits.yaml").write_text("steps:\n  ros__parameters:\n    limit: 1\n")
    live, printed = traced(
        tmp_path, "callbacks", capfd, 1.0, params=[str(tmp_path / "limits.yaml")]
    )
    assert "> sent 2 True 1" in logged(printed)
    assert live.end.cause == "ended"


def test_nothing_gets_out_whatever_the_environment_says(tmp_path, capfd, monkeypatch):
    """The host's own loopback is another one than that of the run: it hears what gets out."""
    heard = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]

        def listen():
            while data := listener.recv(65536):
                heard.append(data)

        hearing = threading.Thread(target=listen)
        hearing.start()
        profile = tmp_path / "profile.xml"
        profile.write_text(PROFILE.format(port=port))
        (tmp_path / "DEFAULT_FASTRTPS_PROFILES.xml").write_text(PROFILE.format(port=port))
        monkeypatch.chdir(tmp_path)
        for name, value in {
            "ROS_DISCOVERY_SERVER": f"127.0.0.1:{port}",
            "FASTRTPS_DEFAULT_PROFILES_FILE": str(profile),
            "FASTDDS_DEFAULT_PROFILES_FILE": str(profile),
            "ROS_STATIC_PEERS": f"127.0.0.1:{port};192.0.2.1",
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET",
            "ROS_DOMAIN_ID": "0",
            "RMW_IMPLEMENTATION": "rmw_zenoh_cpp",
        }.items():
            monkeypatch.setenv(name, value)
        with tempfile.NamedTemporaryFile(dir="/dev/shm", prefix="of_the_host"):
            live, printed = traced(tmp_path, "hostile", capfd, 1.0)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ending:
            ending.sendto(b"", ("127.0.0.1", port))
        hearing.join()
    assert live.verdict.kind == "complete", printed
    assert heard == []
    lines = logged(printed)
    assert "> interfaces ['lo']" in lines
    assert "> shared []" in lines
    assert "> refused 111" in lines
    assert not re.search(r"ROS_DISCOVERY_SERVER|PROFILES_FILE|STATIC_PEERS|SUBNET|zenoh", printed)


def test_blocks_are_written_into_the_functions_of_the_author(tmp_path, example_in):
    example = example_in(tmp_path)
    example.write("pyproject.toml", "")
    example.write("cell.py", (PROGRAMS / "topics_and_services.py").read_text())
    done = example.run(
        *("trace", "cell.py", "--live", "--robot", "panda", "-o", "live.json"),
    )
    assert done.code == 0, done.err
    done = example.run("annotate", "cell.py", "--trace", "live.json")
    assert done.code == 0, done.err
    source = example.read("cell.py").decode()
    assert source.count("RiskAnnotation") == 2
    for name in ("Cell.reach", "Cell.back"):
        assert f"# |   name = {name}" in source
