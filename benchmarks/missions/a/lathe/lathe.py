#!/usr/bin/env python3
"""Unload and load a vertical lathe with an LBR iiwa 7 and a parallel gripper.

A lifecycle node: configured it knows its interfaces, activated it works one cycle.
"""
import math

import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory, GripperCommand
from geometry_msgs.msg import Pose
from moveit_msgs.srv import GetCartesianPath
from rclpy.action import ActionClient
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["lbr_A%d" % i for i in range(1, 8)]
WAIT = [0.0, 0.4, 0.0, -1.7, 0.0, 1.04, 0.0]      # in front of the lathe, tool down
FINGERS = 0.12                                     # flange to finger pads
HIGH, GRIP = 0.20, 0.032                           # of the pads
PLACES = {"pallet": (0.50, -0.25), "chuck": (0.55, 0.20), "outlet": (0.40, 0.32)}
JAWS = {"wide": 0.036, "part": 0.014}
SPEED = 0.5                                        # rad/s of the fastest joint


def duration(seconds):
    fraction, whole = math.modf(seconds)
    return Duration(sec=int(whole), nanosec=int(fraction * 1e9))


class LatheCell(LifecycleNode):
    def on_configure(self, state):
        self.arm = ActionClient(self, FollowJointTrajectory, "/joint_trajectory_controller/follow_joint_trajectory")
        self.jaws = ActionClient(self, GripperCommand, "/gripper_controller/gripper_cmd")
        self.path = self.create_client(GetCartesianPath, "/compute_cartesian_path")
        self.lathe = {name: self.create_client(Trigger, "/lathe/" + name) for name in ("clamp", "release", "run")}
        self.journal = self.create_lifecycle_publisher(String, "/lathe/journal", 10)
        return TransitionCallbackReturn.SUCCESS

    # ------------------------------------------------------------- helpers
    def wait(self, future):
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def act(self, client, goal):
        client.wait_for_server()
        handle = self.wait(client.send_goal_async(goal))
        if not handle.accepted:
            raise RuntimeError("rejected")
        return self.wait(handle.get_result_async()).result

    def machine(self, name):
        answer = self.wait(self.lathe[name].call_async(Trigger.Request()))
        if not answer.success:
            raise RuntimeError("lathe: no %s" % name)

    def joints(self, target, seconds):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [JointTrajectoryPoint(positions=target, velocities=[0.0] * 7,
                                                       time_from_start=duration(seconds))]
        return self.act(self.arm, goal)

    def line(self, *stops):
        """Along straight lines through places (name, height of the pads)."""
        request = GetCartesianPath.Request(group_name="arm", max_step=0.01)
        request.header.frame_id = "lbr_link_0"
        request.start_state.is_diff = True
        for name, height in stops:
            pose = Pose()
            pose.position.x, pose.position.y = PLACES[name]
            pose.position.z = height + FINGERS
            pose.orientation.y, pose.orientation.w = 1.0, 0.0
            request.waypoints.append(pose)
        answer = self.wait(self.path.call_async(request))
        if answer.fraction < 0.999:
            raise RuntimeError("only %.2f of the line" % answer.fraction)
        self.follow(answer.solution.joint_trajectory)

    def follow(self, trajectory):
        """Our own timing: the fastest joint at SPEED, smooth at both ends."""
        points = trajectory.points
        ways = [max(abs(b - a) for a, b in zip(p.positions, q.positions)) for p, q in zip(points, points[1:])]
        total, done = sum(ways), 0.0
        seconds = max(1.0, 1.6 * total / SPEED)
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = list(trajectory.joint_names)
        for way, point in zip(ways, points[1:]):
            done += way
            share = math.acos(1.0 - 2.0 * min(1.0, done / total)) / math.pi
            goal.trajectory.points.append(JointTrajectoryPoint(
                positions=list(point.positions), time_from_start=duration(share * seconds)))
        self.act(self.arm, goal)

    def grip(self, width):
        goal = GripperCommand.Goal()
        goal.command.position = JAWS[width]
        goal.command.max_effort = 18.0
        return self.act(self.jaws, goal)

    # --------------------------------------------------------------- cycle
    def take(self, place):
        self.grip("wide")
        self.line((place, HIGH))
        self.line((place, GRIP))
        self.grip("part")

    def put(self, place):
        self.line((place, HIGH))
        self.line((place, GRIP + 0.001))

    def leave(self, place):
        self.grip("wide")
        self.line((place, HIGH))

    def on_activate(self, state):
        super().on_activate(state)
        self.joints(WAIT, 3.0)
        # the turned part out of the chuck
        self.take("chuck")
        self.machine("release")
        self.line(("chuck", HIGH))
        self.put("outlet")
        self.leave("outlet")
        self.journal.publish(String(data="unloaded"))
        # a blank into it
        self.take("pallet")
        self.line(("pallet", HIGH))
        self.put("chuck")
        self.machine("clamp")
        self.leave("chuck")
        self.joints(WAIT, 2.0)
        self.machine("run")
        self.journal.publish(String(data="loaded"))
        return TransitionCallbackReturn.SUCCESS


def main():
    rclpy.init()
    cell = LatheCell("lathe_cell")
    cell.trigger_configure()
    cell.trigger_activate()
    cell.trigger_deactivate()
    cell.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
