"""Sensors end to end: in the trace, in the blocks, and by whom they are read."""

from dataclasses import replace

import pytest

from tracerisk.adder.figures.computed import compute_blocks
from tracerisk.common import trace_json
from tracerisk.common.hardware.shipped import hardware_of
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.trace import Trace

HARDWARE = """\
robot: panda
components:
  electric_motor: {quantity: 7, probability: {value: 9.5e-08, per: minute}, twin: {joints: "*"}}
  joint_encoder: {failure_rate: {value: 1.0e-06, per: hour}, quantity: 7, twin: {sensors: encoder}}
"""
CAMERA = """\
  camera: {failure_rate: {value: 1.0e-05, per: hour}, twin: {sensors: camera}}
"""
LISTENER = """\
import sys
import moveit_commander, rospy
from sensor_msgs.msg import JointState

seen = []


def first(arm):
    turn(arm, 0.3)
    AFTER


def listen():
    subscriber = rospy.Subscriber("/joint_states", JointState, seen.append)
    rospy.sleep(10.0)
    subscriber.unregister()


def second(arm):
    turn(arm, 0.0)


def turn(arm, angle):
    arm.go([angle, -0.78, 0.0, -2.3, 0.0, 1.57, 0.78], wait=True)


moveit_commander.roscpp_initialize(sys.argv)
rospy.init_node("listener")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)
first(arm)
BETWEEN
second(arm)
"""
WATCHER = """\
import sys
import moveit_commander, rospy, tf2_ros
from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import CameraInfo, Image

moveit_commander.roscpp_initialize(sys.argv)
rospy.init_node("watcher")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)
frames, force = [], []
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)


def move():
    joints = arm.get_current_joint_values()
    joints[0] += 0.1
    arm.go(joints, wait=True)


def look():
    camera = rospy.Subscriber("/camera/color/image_raw", Image, frames.append)
    rospy.wait_for_message("/camera/color/camera_info", CameraInfo)
    rospy.sleep(4.0)
    camera.unregister()
    move()


def feel():
    wrench = rospy.Subscriber("/ft/raw", WrenchStamped, force.append)
    rospy.sleep(2.0)
    wrench.unregister()
    rospy.sleep(1.0)
    buffer.lookup_transform("panda_link5", "panda_link8", rospy.Time(0), rospy.Duration(1.0))
    rospy.sleep(1.0)
    move()


move()
look()
feel()
"""
SCENARIO = """\
publish:
  - {topic: /camera/color/image_raw, type: sensor_msgs/Image, rate: 10}
  - {topic: /camera/color/camera_info, type: sensor_msgs/CameraInfo, rate: 10}
  - {topic: /camera/depth/image_raw, type: sensor_msgs/Image, rate: 10}
  - {topic: /ft/raw, type: geometry_msgs/WrenchStamped}
"""
PUSHER = """\
from threading import Thread
import rclpy
from geometry_msgs.msg import WrenchStamped
from pymoveit2 import MoveIt2
from rclpy.node import Node

rclpy.init()
node, reader = Node("pusher"), Node("reader")
JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
felt = []


def push():
    wrench = reader.create_subscription(
        WrenchStamped, "/force_torque_sensor_broadcaster/wrench", felt.append, 10)
    began = node.get_clock().now()
    while (node.get_clock().now() - began).nanoseconds < 2_000_000_000:
        rclpy.spin_once(reader, timeout_sec=0.1)
    reader.destroy_subscription(wrench)


executor = rclpy.executors.MultiThreadedExecutor(2)
executor.add_node(node)
Thread(target=executor.spin, daemon=True).start()
arm = MoveIt2(node, JOINTS, "base_link", "tool0", "ur_manipulator")
arm.move_to_configuration([0.1, -1.57, 0.0, -1.57, 0.0, 0.0])
arm.wait_until_executed()
push()
arm.move_to_configuration([0.0, -1.57, 0.0, -1.57, 0.0, 0.0])
arm.wait_until_executed()
assert felt and abs(felt[-1].wrench.force.z) < 1e-6 and felt[-1].header.frame_id == "tool0"
print("felt", len(felt))
"""


def hardware_in(folder, text: str):
    path = folder / "hardware.yaml"
    path.write_text(text, encoding="utf-8")
    return read_hardware(path)


def traced(example, name: str, *options: str) -> Trace:
    outcome = example.run("trace", name, "--quiet", "-o", "trace.json", *options)
    assert outcome.code == 0, outcome.err
    return trace_json.loads(example.read("trace.json").decode(), "trace.json")


def exposures(trace: Trace, function: str, element: str, field: str) -> float:
    return sum(
        getattr(found, field)
        for visit in trace.visits
        if visit.function.name == function
        if (found := visit.exposures.get(element)) is not None
    )


def assert_shares_add_up(trace: Trace) -> None:
    for name, whole in trace.active.items():
        found = [each for visit in trace.visits if (each := visit.exposures.get(name)) is not None]
        for field in ("active_s", "reading_s", "moving_s", "holding_s"):
            total = sum(getattr(each, field) for each in found)
            assert total == pytest.approx(getattr(whole, field), abs=1e-9), (name, field)


def components(blocks, name: str) -> list[str]:
    return [
        each.name for ref, block in blocks.items() if ref.name == name for each in block.components
    ]


def test_the_time_of_every_sensor_is_shared_out_among_the_visits(short_trace):
    assert_shares_add_up(short_trace)
    read = short_trace.active["panda_joint1/encoder"].reading_s
    assert 0.0 < read < 0.05 * short_trace.active["panda_joint1/encoder"].active_s


def test_an_encoder_that_is_bound_is_in_each_function_that_moves(short_trace, tmp_path):
    blocks = compute_blocks(short_trace, hardware_in(tmp_path, HARDWARE), active="moving+holding")
    for name in ("init", "pick_position", "pick", "place_position"):
        assert components(blocks.blocks, name) == ["electric_motor", "joint_encoder"]


def test_sensors_that_nobody_binds_change_no_block(short_trace):
    kept = tuple(each for each in short_trace.elements if each.kind != "sensor")
    names = {each.name for each in kept}
    without = replace(
        short_trace,
        elements=kept,
        visits=tuple(
            replace(visit, exposures={k: v for k, v in visit.exposures.items() if k in names})
            for visit in short_trace.visits
        ),
    )
    hardware = hardware_of("panda")
    found, expected = (
        compute_blocks(each, hardware, active="moving+holding") for each in (short_trace, without)
    )
    assert found.blocks == expected.blocks


@pytest.fixture(scope="module")
def listened(tmp_path_factory, example_in) -> Trace:
    example = example_in(tmp_path_factory.mktemp("listener"))
    text = LISTENER.replace("AFTER", "pass").replace("BETWEEN", "listen()")
    example.write("listener.py", text)
    return traced(example, "listener.py")


def test_who_only_listens_leans_on_encoders_and_no_motor(listened):
    # The first joint has nothing to bear: it stands still, and its motor rests. It listens for
    # 10 s, of which the connection takes 0.05.
    motor = exposures(listened, "first", "panda_joint1", "active_s")
    encoder = exposures(listened, "first", "panda_joint1/encoder", "active_s")
    assert motor < 3.0
    assert encoder == pytest.approx(motor + 9.95, abs=0.2)
    for kind in ("encoder", "torque"):
        read = exposures(listened, "first", f"panda_joint1/{kind}", "reading_s")
        assert read == pytest.approx(9.95, abs=0.02)
    assert exposures(listened, "second", "panda_joint1/encoder", "reading_s") < 0.05
    assert_shares_add_up(listened)


@pytest.mark.slow
def test_listening_counts_alike_wherever_it_is_written(listened, example):
    inlined = LISTENER.replace("AFTER", "listen()").replace("BETWEEN", "pass")
    example.write("listener.py", inlined)
    other = traced(example, "listener.py")
    for name, whole in listened.active.items():
        assert other.active[name].active_s == pytest.approx(whole.active_s, rel=0.01, abs=1e-6)
        assert other.active[name].reading_s == pytest.approx(whole.reading_s, rel=0.01, abs=1e-6)


def test_a_camera_that_the_scenario_feeds_is_a_component_where_it_is_bound(example, tmp_path):
    example.write("watcher.py", WATCHER)
    example.write("scenario.yaml", SCENARIO)
    example.write("hardware.yaml", HARDWARE + CAMERA.replace("camera}", "[camera/color]}"))
    trace = traced(
        example, "watcher.py", "--scenario", "scenario.yaml", "--hardware", "hardware.yaml"
    )
    sensors = {each.name: each.sensor for each in trace.elements if each.part is None}
    del sensors["panda_hand"]
    assert {name: kind for name, kind in sensors.items() if kind} == {
        "camera/color": "camera",
        "camera/depth": "camera",
        "ft/raw": "wrench",
    }
    # What is done before the motion of `look` belongs to the visit before it, of `<module>`'s.
    assert trace.active["camera/color"].reading_s == pytest.approx(4.1, abs=0.2)
    assert trace.active["camera/depth"].reading_s == 0.0
    # Where frames are to one another, the encoders between them tell.
    read = [trace.active[f"panda_joint{i}/encoder"].reading_s for i in range(1, 8)]
    assert read == pytest.approx([read[0]] * 5 + [read[0] + 0.02] * 2, abs=0.003)
    # A topic that comes at no rate is read until the subscription ends.
    assert trace.active["ft/raw"].reading_s == pytest.approx(1.95, abs=0.02)
    assert_shares_add_up(trace)
    blocks = compute_blocks(
        trace, read_hardware(example.folder / "hardware.yaml"), active="moving+holding"
    )
    assert "camera" in {c.name for block in blocks.blocks.values() for c in block.components}


def test_a_camera_that_no_scenario_has_cannot_be_bound(example, quick):
    example.write("quick.py", quick())
    example.write("hardware.yaml", HARDWARE + CAMERA)
    outcome = example.run("trace", "quick.py", "--hardware", "hardware.yaml")
    assert outcome.code == 2
    assert "hardware.yaml:5" in outcome.err
    assert "camera" in outcome.err


def test_the_wrist_of_an_e_series_is_read_by_its_topic(example):
    example.write("pusher.py", PUSHER)
    trace = traced(example, "pusher.py", "--robot", "ur5e")
    assert trace.active["tcp_fts_sensor"].reading_s == pytest.approx(2.0, abs=0.05)
    assert trace.active["tcp_fts_sensor"].moving_s == 0.0
    assert_shares_add_up(trace)
