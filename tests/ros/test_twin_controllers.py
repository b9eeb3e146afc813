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
