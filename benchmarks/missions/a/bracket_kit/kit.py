#!/usr/bin/env python
# Kit of one bracket, one bushing and one plate; UR5e with a two finger gripper.
# A table of states: each function does its work and returns the name of the next state.
from collections import namedtuple

import actionlib
import rospy
from control_msgs.msg import (FollowJointTrajectoryAction, FollowJointTrajectoryGoal,
                              GripperCommandAction, GripperCommandGoal)
from geometry_msgs.msg import PoseStamped
from moveit_msgs.srv import GetPositionIK, GetPositionIKRequest
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
HOME = [0.0, -1.75, 1.75, -1.57, -1.57, 0.0]
FINGERS = 0.12       # tool0 to the middle of the finger pads [m]
SAFE_Z = 0.18        # of the pads
SPEED = 0.8          # rad/s of the fastest joint

Part = namedtuple("Part", "name source target grip_z half_width")

ORDER = [
    Part("plate", (0.45, 0.35), (0.45, -0.20), 0.025, 0.0125),
    Part("bracket", (0.45, 0.25), (0.45, -0.30), 0.020, 0.0150),
    Part("bushing", (0.45, 0.15), (0.55, -0.25), 0.025, 0.0150),
]

rospy.init_node("kit")
arm = actionlib.SimpleActionClient("/scaled_pos_joint_traj_controller/follow_joint_trajectory",
                                   FollowJointTrajectoryAction)
gripper = actionlib.SimpleActionClient("/gripper_controller/gripper_cmd", GripperCommandAction)
arm.wait_for_server()
gripper.wait_for_server()
ik = rospy.ServiceProxy("/compute_ik", GetPositionIK)
events = rospy.Publisher("/kit/events", String, queue_size=5)
label = rospy.ServiceProxy("/kit/label", Trigger)

memory = {"joints": list(HOME), "todo": list(ORDER), "part": None, "tries": 0}


def follow(*targets):
    """Through joint positions, one after the other, each reached at rest."""
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = JOINTS
    clock, last = 0.0, memory["joints"]
    for target in targets:
        clock += max(0.6, max(abs(a - b) for a, b in zip(target, last)) / SPEED * 1.6)
        goal.trajectory.points.append(JointTrajectoryPoint(
            positions=target, velocities=[0.0] * 6, time_from_start=rospy.Duration.from_sec(clock)))
        last = target
    arm.send_goal_and_wait(goal)
    memory["joints"] = list(last)
    return arm.get_result().error_code == 0


def joints_at(xy, z):
    req = GetPositionIKRequest()
    req.ik_request.group_name = "manipulator"
    req.ik_request.ik_link_name = "tool0"
    req.ik_request.robot_state.joint_state = JointState(name=JOINTS, position=memory["joints"])
    pose = PoseStamped()
    pose.header.frame_id = "base_link"
    pose.pose.position.x, pose.pose.position.y = xy
    pose.pose.position.z = z + FINGERS
    pose.pose.orientation.x = 1.0
    req.ik_request.pose_stamped = pose
    res = ik(req)
    if res.error_code.val != res.error_code.SUCCESS:
        raise rospy.ROSException("no joints for %s at %.3f" % (xy, z))
    state = dict(zip(res.solution.joint_state.name, res.solution.joint_state.position))
    return [state[j] for j in JOINTS]


def fingers(half_opening):
    goal = GripperCommandGoal()
    goal.command.position = half_opening
    goal.command.max_effort = 18.0
    gripper.send_goal_and_wait(goal, rospy.Duration(4.0))
    return gripper.get_result()


# ------------------------------------------------------------------ states
def start():
    follow(HOME)
    fingers(0.04)
    return "next_part"


def next_part():
    if not memory["todo"]:
        return "finish"
    memory["part"] = memory["todo"].pop(0)
    memory["tries"] = 0
    return "pick"


def pick():
    part = memory["part"]
    above = joints_at(part.source, SAFE_Z)
    follow(above)
    follow(joints_at(part.source, part.grip_z))
    result = fingers(part.half_width - 0.006)
    follow(above)
    if result.stalled:
        return "place"
    memory["tries"] += 1
    fingers(0.04)
    return "pick" if memory["tries"] < 2 else "give_up"


def place():
    part = memory["part"]
    above = joints_at(part.target, SAFE_Z)
    follow(above, joints_at(part.target, part.grip_z + 0.001))
    fingers(0.04)
    follow(above)
    events.publish(part.name)
    return "next_part"


def give_up():
    rospy.logerr("cannot grip the %s", memory["part"].name)
    events.publish("missing " + memory["part"].name)
    return "next_part"


def finish():
    follow(HOME)
    label()
    return None


STATES = {f.__name__: f for f in (start, next_part, pick, place, give_up, finish)}

if __name__ == "__main__":
    state = "start"
    while state is not None and not rospy.is_shutdown():
        rospy.loginfo("state %s", state)
        state = STATES[state]()
