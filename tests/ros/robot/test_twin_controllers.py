"""The services of the controller manager, as programs call them."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.messages.fields import service_parts
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.robot.controllers import ControllerManager
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.twin_interfaces import TwinInterfaces
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin

PROGRAM = """
import rospy
from controller_manager_msgs.srv import (
    ListControllers, LoadController, SwitchController, SwitchControllerRequest, UnloadController)

rospy.init_node("switcher")
rospy.wait_for_service("/arm/controller_manager/list_controllers")
listing = rospy.ServiceProxy("/arm/controller_manager/list_controllers", ListControllers)
switch = rospy.ServiceProxy("/arm/controller_manager/switch_controller", SwitchController)
states = lambda: {each.name: each.state for each in listing().controller}
first = states()
claimed = [each.claimed_resources[0].resources for each in listing().controller][0]
request = SwitchControllerRequest(
    start_controllers=[], stop_controllers=["panda_arm_controller"], strictness=2)
stopped = switch(request).ok, states()["panda_arm_controller"]
request.stop_controllers = ["joint_impedance_controller"]
unknown = switch(request).ok
load = rospy.ServiceProxy("/arm/controller_manager/load_controller", LoadController)
load("joint_impedance_controller")
loaded = switch(request).ok
request.start_controllers, request.stop_controllers = ["joint_impedance_controller"], []
started = switch(request).ok
request.start_controllers, request.stop_controllers = [], ["joint_impedance_controller"]
switch(request)
unload = rospy.ServiceProxy("/arm/controller_manager/unload_controller", UnloadController)
unloaded = unload("joint_impedance_controller").ok, unload("panda_hand_controller").ok
"""


def test_controllers_are_listed_loaded_and_switched(run_on_twin):
    ran = run_on_twin(PROGRAM)
    assert ran["first"]["panda_arm_controller"] == "running"
    assert ran["claimed"] == [f"panda_joint{i}" for i in range(1, 8)]
    assert ran["stopped"] == (True, "stopped")
    # One that does not run cannot be stopped strictly.
    assert (ran["unknown"], ran["loaded"], ran["started"]) == (False, False, True)
    assert ran["unloaded"] == (True, False)


FOUND = """
import rospy
from controller_manager_msgs import utils

rospy.init_node("finder")
rospy.set_param("/arm/stiff_controller", {"type": "effort_controllers/Stiff", "gains": {"type": "p"}})
managers = utils.get_controller_managers("/arm"), utils.ControllerManagerLister()()
is_one = utils.is_controller_manager("/arm/controller_manager")
listed = utils.ControllerLister("/arm/controller_manager")()
none = utils.filter_by_name(listed, "panda_arm")
stopped = [each.name for each in utils.filter_by_state(listed, "stopped")]
names = lambda found: [each.name for each in found]
by_name = names(utils.filter_by_name(listed, "panda_arm", match_substring=True))
by_type = names(utils.filter_by_type(listed, "position_controllers/JointTrajectoryController"))
claims = names(utils.filter_by_resources(listed, ["panda_joint1", "panda_joint7"]))
any_of = names(utils.filter_by_resources(listed, ["panda_joint1", "lift"], match_any=True))
moved = utils.filter_by_hardware_interface(listed, "PositionJoint", match_substring=True)
of_effort = utils.filter_by_hardware_interface(listed, "hardware_interface::EffortJointInterface")
configured = utils.get_rosparam_controller_names("/arm")
"""


def test_managers_and_their_controllers_are_found_and_filtered(run_on_twin):
    ran = run_on_twin(FOUND)
    arms = "/arm/controller_manager"
    assert ran["managers"] == ([arms], [arms, "/controller_manager"])
    assert ran["is_one"]
    assert ran["none"] == ran["of_effort"] == []
    arm = ["panda_arm_controller"]
    # Of those for the same joints the first runs.
    assert "position_joint_trajectory_controller" in ran["stopped"]
    assert arm[0] not in ran["stopped"]
    assert arm[0] in ran["by_name"]
    assert set(arm) <= set(ran["by_type"])
    assert set(arm) <= set(ran["claims"]) == set(ran["any_of"])
    assert arm[0] in [each.name for each in ran["moved"]]
    assert ran["configured"] == ["stiff_controller"]


def test_in_ros_2_controllers_are_activated(world):
    scheduler = Scheduler(world, duration_ns=1_000_000_000)
    graph = Graph(scheduler)
    interfaces = Interfaces2()
    runtime = Runtime(scheduler, graph, SimpleNamespace(robot=load_robot("panda")))
    ControllerManager(runtime, TwinMessages(interfaces))
    kind = interfaces.service("controller_manager_msgs/SwitchController")
    request = kind.Request(deactivate_controllers=["panda_arm_controller"], strictness=2)
    assert graph.services.find("/controller_manager/switch_controller").handle(request).ok
    listing = graph.services.find("/controller_manager/list_controllers").handle(None)
    found = {each.name: each for each in listing.controller}
    assert found["panda_arm_controller"].state == "inactive"
    assert found["panda_hand_controller"].claimed_interfaces[0] == "panda_finger_joint1/position"


def test_humble_switches_by_the_older_fields_too(world):
    graph = Graph(Scheduler(world, duration_ns=1_000_000_000))
    interfaces = Interfaces2(rules=DistroRules("humble"))
    runtime = Runtime(graph.scheduler, graph, SimpleNamespace(robot=load_robot("panda")))
    ControllerManager(runtime, TwinMessages(interfaces))
    kind = interfaces.service("controller_manager_msgs/SwitchController")
    switch = graph.services.find("/controller_manager/switch_controller")

    def running():
        listed = graph.services.find("/controller_manager/list_controllers").handle(None).controller
        return {each.name for each in listed if each.state == "active"}

    name = "panda_arm_controller"
    hand = "panda_hand_controller"
    for older, newer, expected in [
        ({"stop_controllers": [name]}, {}, {hand}),
        ({"start_controllers": [name]}, {}, {name, hand}),
        ({"stop_controllers": [name]}, {"deactivate_controllers": [hand]}, set()),
    ]:
        assert switch.handle(kind.Request(strictness=2, **older, **newer)).ok
        assert running() & {name, hand} == expected


DECLARED = """\
controller_manager:
  ros__parameters:
    arm_controller: {type: joint_trajectory_controller/JointTrajectoryController}
    arm_velocity_controller: {type: velocity_controllers/JointGroupVelocityController}
    hand_controller: {type: position_controllers/GripperActionController}
arm_controller:
  ros__parameters: {joints: [panda_joint1, panda_joint2]}
arm_velocity_controller:
  ros__parameters: {joints: [panda_joint1, panda_joint2]}
hand_controller:
  ros__parameters: {joint: panda_finger_joint1}
"""
BEST_EFFORT, STRICT = 1, 2
SWITCHES = {
    # what: (start, stop, strictness, for each distribution whether it is done and what runs then)
    "one for another": ("arm_velocity", "arm", STRICT, [(True, "arm_velocity hand")] * 3),
    "one that claims the same joints": (
        "arm_velocity", "", STRICT, [(False, "arm hand")] * 3),
    "one that claims the same joints, at best": (
        "arm_velocity", "hand", BEST_EFFORT, [(False, "arm hand"), *[(True, "arm")] * 2]),
    "one that runs": ("arm", "", STRICT, [(False, "arm hand")] * 3),
    "one that runs, at best": ("arm", "", BEST_EFFORT, [(True, "arm hand")] * 3),
    "one that does not run": ("", "arm_velocity", STRICT, [(False, "arm hand")] * 3),
    "an unknown one": ("laser", "arm", STRICT, [(False, "arm hand")] * 3),
    "an unknown one, at best": (
        "laser", "arm", BEST_EFFORT, [*[(True, "hand")] * 2, (False, "arm hand")]),
    "an unknown one beside another, at best": (
        "laser arm_velocity", "arm", BEST_EFFORT, [(True, "arm_velocity hand")] * 3),
    "a restart": ("arm", "arm", STRICT, [(True, "arm hand")] * 3),
    "no strictness": ("laser arm_velocity", "arm", 0, [(True, "arm_velocity hand")] * 3),
}  # fmt: skip


@pytest.mark.parametrize("distro", ["noetic", "humble", "jazzy"])
@pytest.mark.parametrize("what", SWITCHES)
def test_switch(what, distro, world, tmp_path):
    start, stop, strictness, expected = SWITCHES[what]
    (tmp_path / "controllers.yaml").write_text(DECLARED)
    robot = replace(load_robot("panda"), controllers=())
    scheduler = Scheduler(world, duration_ns=1_000_000_000)
    graph = Graph(scheduler)
    interfaces = Interfaces() if distro == "noetic" else Interfaces2(rules=DistroRules(distro))
    runtime = Runtime(
        scheduler,
        graph,
        SimpleNamespace(robot=robot),
        packages={"cell": tmp_path},
        distro=DistroRules(distro),
    )
    ControllerManager(runtime, TwinMessages(interfaces))
    names = ("start", "stop") if distro == "noetic" else ("activate", "deactivate")
    request = service_parts(interfaces, "controller_manager_msgs/SwitchController")[0]()
    request.strictness = strictness
    for name, asked in zip(names, (start, stop), strict=True):
        setattr(request, f"{name}_controllers", [f"{each}_controller" for each in asked.split()])
    ok = graph.services.find("/controller_manager/switch_controller").handle(request).ok
    listing = graph.services.find("/controller_manager/list_controllers").handle(None)
    runs = " ".join(
        sorted(
            each.name.removesuffix("_controller")
            for each in listing.controller
            if each.state in ("running", "active") and not each.name.startswith("joint_state_")
        )
    )
    assert (ok, runs) == expected[("noetic", "humble", "jazzy").index(distro)]


GROUPS = """\
position_group: {type: position_controllers/JointGroupPositionController, joints: [panda_joint1, panda_joint2]}
velocity_group: {type: velocity_controllers/JointGroupVelocityController, joints: [panda_joint1, panda_joint2]}
effort_group: {type: effort_controllers/JointGroupEffortController, joints: [panda_joint1, panda_joint2]}
forwarding: {type: forward_command_controller/ForwardCommandController, joints: [panda_joint1],
             interface_name: velocity}
"""
OF_GROUPS = {
    # what: (controller, its values, what the first joint does in 1 s, words of the finding)
    "positions": ("position_group", [0.3, -0.5], 0.3, ""),
    "a position too few": ("position_group", [0.3], 0.0, "1 values, and its controller 2 joints"),
    "positions too many": ("position_group", [0.3] * 7, 0.0, "7 values"),
    "velocities that go on": ("velocity_group", [0.2, 0.0], 0.2, ""),
    "a velocity too few": ("velocity_group", [0.2], 0.0, "1 values"),
    "efforts": ("effort_group", [1.0, 1.0], 0.0, "commands of effort are not simulated"),
    "velocities by interface_name": ("forwarding", [0.2], 0.2, ""),
    "a position that is no number": ("position_group", [float("nan"), 0.0], 0.0, "not finite"),
    "an infinite velocity": ("velocity_group", [float("inf"), 0.0], 0.0, "not finite"),
    "no values": ("position_group", [], 0.0, "0 values"),
}


@pytest.mark.parametrize("what", OF_GROUPS)
def test_group(what, tmp_path):
    name, values, moved, words = OF_GROUPS[what]
    (tmp_path / "controllers.yaml").write_text(GROUPS)
    twin = Twin.build(load_robot("panda"), load_scene("empty"))
    scheduler = Scheduler(twin, duration_ns=10_000_000_000)
    graph, interfaces = Graph(scheduler), Interfaces2()
    found: list[str] = []
    recorder = SimpleNamespace(failed=lambda kind, message, *_, **__: not found.append(message))
    runtime = Runtime(scheduler, graph, twin, recorder=recorder, packages={"cell": tmp_path})
    TwinInterfaces(runtime, interfaces)
    message = interfaces.message("std_msgs/Float64MultiArray")()
    message.data = values

    def main():
        topic = graph.advertise(f"/{name}/commands", "std_msgs/Float64MultiArray", node="/n")
        topic.publish(message)
        scheduler.sleep(1_000_000_000)
        return twin.joint_state().positions["panda_joint1"]

    assert scheduler.run_main(main) == pytest.approx(moved, abs=0.02)
    assert bool(found) == bool(words)
    assert all(words in message for message in found)
