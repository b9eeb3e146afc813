"""Packages that the installed ROS lacks are made from our texts, with the sums of the public ones."""

import json
import subprocess
from pathlib import Path

from tracerisk.ros.live.messages.modules import make_missing_modules
from tracerisk.ros.messages.ros1 import Interfaces

SOURCE = b"""
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from control_msgs.msg import GripperCommandAction, JointTolerance
from control_msgs.srv import QueryTrajectoryState
from geometry_msgs.msg import Pose
"""
ASK = """
import json, sys
sys.path.append(sys.argv[1])
import control_msgs.msg as m, control_msgs.srv as s
g = m.FollowJointTrajectoryGoal()
g.trajectory.joint_names = ["a"]
import io
b = io.BytesIO(); g.serialize(b)
names = ["FollowJointTrajectoryAction", "FollowJointTrajectoryGoal", "GripperCommandAction",
         "JointTolerance"]
sums = {n: getattr(m, n)._md5sum for n in names}
sums["QueryTrajectoryState"] = s.QueryTrajectoryState._md5sum
print(json.dumps([sums, b.getvalue().hex()]))
"""
PUBLIC = {
    "FollowJointTrajectoryAction": "bc4f9b743838566551c0390c65f1a248",
    "FollowJointTrajectoryGoal": "69636787b6ecbde4d61d711979bc7ecb",
    "GripperCommandAction": "950b2a6ebe831f5d4f4ceaba3d8be01e",
    "JointTolerance": "f544fe9c16cf04547e135dd6063ff5be",
    "QueryTrajectoryState": "ec93cdecbd8062d761aa52b7c90cd44b",
}
"""As the packages of ROS Noetic have them."""


def test_modules_are_made_with_the_public_sums(real_ros: str, tmp_path: Path) -> None:
    interfaces = Interfaces()
    made = make_missing_modules(interfaces, [SOURCE], tmp_path)
    if not made:
        return  # this ROS has control_msgs of its own
    done = subprocess.run(
        [real_ros, "-s", "-c", ASK, str(tmp_path)], capture_output=True, text=True, check=True
    )
    sums, body = json.loads(done.stdout)
    assert sums == PUBLIC
    assert not (tmp_path / "geometry_msgs").exists(), "the installed package is the one to use"
    goal = interfaces.message("control_msgs/FollowJointTrajectoryGoal")()
    goal.deserialize(bytes.fromhex(body))
    assert goal.trajectory.joint_names == ["a"]


def test_nothing_is_made_where_nothing_is_missing(real_ros: str, tmp_path: Path) -> None:
    del real_ros
    source = b"from geometry_msgs.msg import Pose\nimport rospy\n"
    assert not make_missing_modules(Interfaces(), [source], tmp_path)
    assert list(tmp_path.iterdir()) == []
