"""The services of the controller manager, as programs call them."""

from __future__ import annotations

from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.robot.controllers import ControllerManager
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.twin.robots.robot import load_robot

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
unload = rospy.ServiceProxy("/arm/controller_manager/unload_controller", UnloadController)
unloaded = unload("joint_impedance_controller").ok, unload("panda_hand_controller").ok
"""


def test_controllers_are_listed_loaded_and_switched(run_on_twin):
    ran = run_on_twin(PROGRAM)
    assert ran["first"]["panda_arm_controller"] == "running"
    assert ran["claimed"] == [f"panda_joint{i}" for i in range(1, 8)]
    assert ran["stopped"] == (True, "stopped")
    assert (ran["unknown"], ran["loaded"]) == (False, True)
    assert ran["unloaded"] == (True, False)


FOUND = """
import rospy
from controller_manager_msgs import utils

rospy.init_node("finder")
rospy.set_param("/arm/stiff_controller", {"type": "effort_controllers/Stiff", "gains": {"type": "p"}})
managers = utils.get_controller_managers("/arm"), utils.ControllerManagerLister()()
is_one = utils.is_controller_manager("/arm/controller_manager")
listed = utils.ControllerLister("/arm/controller_manager")()
none = utils.filter_by_name(listed, "panda_arm") + utils.filter_by_state(listed, "stopped")
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
    assert arm[0] in ran["by_name"]
    assert set(arm) <= set(ran["by_type"])
    assert set(arm) <= set(ran["claims"]) == set(ran["any_of"])
    assert arm[0] in [each.name for each in ran["moved"]]
    assert ran["configured"] == ["stiff_controller"]


def test_in_ros_2_controllers_are_activated(world):
    from types import SimpleNamespace

    scheduler = Scheduler(world, duration_ns=1_000_000_000)
    graph = Graph(scheduler)
    interfaces = Interfaces2()
    runtime = Runtime(scheduler, graph, SimpleNamespace(robot=load_robot("panda")))
    ControllerManager(runtime, TwinMessages(interfaces))
    kind = interfaces.service("controller_manager_msgs/SwitchController")
    request = kind.Request(deactivate_controllers=["panda_arm_controller"], strictness=2)
    assert graph.service("/controller_manager/switch_controller").handle(request).ok
    listing = graph.service("/controller_manager/list_controllers").handle(None)
    found = {each.name: each for each in listing.controller}
    assert found["panda_arm_controller"].state == "inactive"
    assert found["panda_hand_controller"].claimed_interfaces[0] == "panda_finger_joint1/position"
