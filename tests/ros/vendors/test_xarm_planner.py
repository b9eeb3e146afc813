"""The services of xarm_planner: a motion is planned by one, and carried out by another."""

import pytest

HEAD = """
import rclpy
from geometry_msgs.msg import Point, Pose, Quaternion
from xarm_msgs.srv import PlanExec, PlanJoint, PlanPose, PlanSingleStraight
from sensor_msgs.msg import JointState
rclpy.init()
node = rclpy.create_node('drawer')
here = {}
node.create_subscription(JointState, 'joint_states', lambda m: here.update(zip(m.name, m.position)), 1)
def call(kind, service, **fields):
    client = node.create_client(kind, service)
    client.wait_for_service()
    future = client.call_async(kind.Request(**fields))
    rclpy.spin_until_future_complete(node, future)
    rclpy.spin_once(node, timeout_sec=0.5)
    return future.result().success
def joint(name):
    for _ in range(5):
        rclpy.spin_once(node, timeout_sec=0.2)
    return here[name]
"""


def test_a_plan_moves_nothing_until_it_is_executed(run_on):
    ran = run_on(
        "xarm6",
        HEAD
        + """
planned = call(PlanJoint, '/xarm_joint_plan', target=[0.4, 0.0, -0.6, 0.0, 0.6, 0.0])
before = joint('joint1')
done = call(PlanExec, '/xarm_exec_plan', wait=True)
after = joint('joint1')
down = Pose(position=Point(x=0.3, y=0.1, z=0.3), orientation=Quaternion(x=1.0, w=0.0))
pose = call(PlanPose, '/xarm_pose_plan', target=down) and call(PlanExec, '/xarm_exec_plan', wait=True)
down.position.y = 0.15
line = call(PlanSingleStraight, '/xarm_straight_plan', target=down)
drawn = call(PlanExec, '/xarm_exec_plan', wait=True)
""",
        ros=2,
    )
    assert (ran["planned"], ran["done"], ran["pose"], ran["line"], ran["drawn"]) == (True,) * 5
    assert ran["before"] == pytest.approx(0.0, abs=0.01)
    assert ran["after"] == pytest.approx(0.4, abs=0.02)
    assert ran.commands == ["xarm_exec_plan"] * 3


def test_without_a_plan_or_from_elsewhere_nothing_is_executed(run_on):
    ran = run_on(
        "xarm6",
        HEAD
        + """
none = call(PlanExec, '/xarm_exec_plan', wait=True)
far = Pose(position=Point(x=3.0, z=0.3), orientation=Quaternion(x=1.0, w=0.0))
unreached = call(PlanPose, '/xarm_pose_plan', target=far)
call(PlanJoint, '/xarm_joint_plan', target=[0.4, 0.0, -0.6, 0.0, 0.6, 0.0])
done = call(PlanExec, '/xarm_exec_plan', wait=True)
again = call(PlanExec, '/xarm_exec_plan', wait=True)
""",
        ros=2,
    )
    assert (ran["none"], ran["unreached"], ran["done"], ran["again"]) == (False, False, True, False)
    assert ran.commands == ["xarm_exec_plan"]
