"""MotoROS2's modes of motion, its queue of points and its state, which are described as data."""

import pytest

HEAD = """
import rclpy
from rclpy.action import ActionClient
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from industrial_msgs.msg import RobotStatus
from motoros2_interfaces.srv import (
    QueueTrajPoint, ReadSingleIO, ResetError, StartPointQueueMode, StartTrajMode, WriteSingleIO,
)
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint
rclpy.init()
node = rclpy.create_node('client')

def call(kind, name, **fields):
    client = node.create_client(kind, name)
    assert client.wait_for_service(1.0), name
    future = client.call_async(kind.Request(**fields))
    rclpy.spin_until_future_complete(node, future)
    return future.result()

NAMES = [f'group_1/joint_{number}' for number in range(1, 7)]

def queue(*positions, names=NAMES, name='/queue_traj_point'):
    point = JointTrajectoryPoint(positions=list(positions), velocities=[0.0] * 6)
    return call(QueueTrajPoint, name, joint_names=names, point=point).result_code.value
"""


@pytest.fixture
def ran_on_gp8(run_on):
    return lambda body: run_on("gp8", HEAD + body, ros=2)


def test_points_of_the_queue_move_the_arm_once_its_mode_is_started(ran_on_gp8):
    ran = ran_on_gp8(
        """
import time
early = queue(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
started = call(StartPointQueueMode, '/start_point_queue_mode').result_code.value
codes = [queue(0.0, 0.0, 0.0, 0.0, 0.02 * step, 0.0) for step in range(6) if not time.sleep(0.1)]
time.sleep(1.0)
short = queue(0.0, 0.0)
"""
    )
    assert (ran["early"], ran["started"], ran["short"]) == (2, 1, 5)
    assert ran["codes"] == [1] * 6
    assert ran.position("joint_5_b") == pytest.approx(0.1, abs=5e-3)


def test_one_mode_is_active_until_it_is_stopped(ran_on_gp8):
    ran = ran_on_gp8(
        """
codes = [
    call(StartTrajMode, '/start_traj_mode').result_code.value,
    call(StartTrajMode, '/start_traj_mode').result_code.value,
    call(StartPointQueueMode, '/start_point_queue_mode').result_code.value,
    queue(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
]
stopped = call(Trigger, '/stop_traj_mode').success
after = call(StartPointQueueMode, '/start_point_queue_mode').result_code.value
"""
    )
    assert ran["codes"] == [1, 1, 114, 2]
    assert (ran["stopped"], ran["after"]) == (True, 1)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("namespace", ["", "/yaskawa", "/r1"])
def test_its_state_its_pins_and_its_queue_are_served_in_any_namespace(ran_on_gp8, namespace):
    ran = ran_on_gp8(
        f"""
before = []
node.create_subscription(RobotStatus, '{namespace}/robot_status', before.append, 1)
for _ in range(20):
    rclpy.spin_once(node, timeout_sec=0.1)
ready = before[-1].motion_possible.val
started = call(StartTrajMode, '{namespace}/start_traj_mode').result_code.value
for _ in range(20):
    rclpy.spin_once(node, timeout_sec=0.1)
after = before[-1].motion_possible.val
cleared = call(ResetError, '{namespace}/reset_error').result_code.value
pin = call(ReadSingleIO, '{namespace}/read_single_io', address=10010)
written = call(WriteSingleIO, '{namespace}/write_single_io', address=10010, value=1)
pins = [pin.success, pin.value, written.success]
trajectories = ActionClient(node, FollowJointTrajectory, '{namespace}/follow_joint_trajectory')
there = trajectories.wait_for_server(1.0)
"""
    )
    assert (ran["ready"], ran["started"], ran["after"], ran["cleared"]) == (0, 1, 1, 1)
    assert ran["pins"] == [True, 0, True]
    assert ran["there"] is True
