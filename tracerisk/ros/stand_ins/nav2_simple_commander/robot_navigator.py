"""BasicNavigator: a node that sends goals to Nav2, which somebody else has to serve.

Source: ros-navigation/navigation2 (branch jazzy), nav2_simple_commander/robot_navigator.py.
"""

from __future__ import annotations

import time
from enum import Enum
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from lifecycle_msgs.srv import GetState
from nav2_msgs.action import (
    AssistedTeleop,
    BackUp,
    ComputePathThroughPoses,
    ComputePathToPose,
    DriveOnHeading,
    FollowPath,
    FollowWaypoints,
    NavigateThroughPoses,
    NavigateToPose,
    SmoothPath,
    Spin,
)
from nav2_msgs.srv import ClearEntireCostmap, LoadMap, ManageLifecycleNodes
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy

_ACTIONS = {
    "navigate_to_pose": NavigateToPose,
    "navigate_through_poses": NavigateThroughPoses,
    "follow_waypoints": FollowWaypoints,
    "follow_path": FollowPath,
    "compute_path_to_pose": ComputePathToPose,
    "compute_path_through_poses": ComputePathThroughPoses,
    "smooth_path": SmoothPath,
    "spin": Spin,
    "backup": BackUp,
    "drive_on_heading": DriveOnHeading,
    "assisted_teleop": AssistedTeleop,
}
_SERVICES = {
    "global_costmap/clear_entirely_global_costmap": ClearEntireCostmap,
    "local_costmap/clear_entirely_local_costmap": ClearEntireCostmap,
    "map_server/load_map": LoadMap,
    "lifecycle_manager_navigation/manage_nodes": ManageLifecycleNodes,
    "lifecycle_manager_localization/manage_nodes": ManageLifecycleNodes,
}
_MANAGERS = tuple(name for name in _SERVICES if name.endswith("manage_nodes"))


class TaskResult(Enum):
    """What became of the last task."""

    UNKNOWN = 0
    SUCCEEDED = 1
    CANCELED = 2
    FAILED = 3


class BasicNavigator(Node):  # type: ignore[misc]  # of the stand-in, which has no type here
    """Sends a mobile base to poses, and says how far it is.

    Clients are made when they are first used: only then does anybody have to serve them.
    """

    def __init__(self, node_name: str = "basic_navigator", namespace: str = "") -> None:
        super().__init__(node_name=node_name, namespace=namespace)
        self.initial_pose = PoseStamped()
        self.initial_pose.header.frame_id = "map"
        self.goal_handle: Any = None
        self.result_future: Any = None
        self.feedback: Any = None
        self.status: int | None = None
        self.initial_pose_received = False
        self._made: dict[str, Any] = {}
        latched = QoSProfile(
            durability=QoSDurabilityPolicy.TRANSIENT_LOCAL,
            reliability=QoSReliabilityPolicy.RELIABLE,
            history=QoSHistoryPolicy.KEEP_LAST,
            depth=1,
        )
        self._localised = latched
        self.initial_pose_pub = self.create_publisher(PoseWithCovarianceStamped, "initialpose", 10)

    # Where the base is

    def setInitialPose(self, initial_pose: Any) -> None:
        """Publish where the base is."""
        self.initial_pose_received = False
        self.initial_pose = initial_pose
        self._publish_initial_pose()

    def _publish_initial_pose(self) -> None:
        message = PoseWithCovarianceStamped()
        message.pose.pose = self.initial_pose.pose
        message.header = self.initial_pose.header
        self.initial_pose_pub.publish(message)

    # Tasks

    def goToPose(self, pose: Any, behavior_tree: str = "") -> bool:
        """Drive to a pose; return whether the goal was taken."""
        goal = NavigateToPose.Goal(pose=pose, behavior_tree=behavior_tree)
        return self._begin("navigate_to_pose", goal)

    def goThroughPoses(self, poses: Any, behavior_tree: str = "") -> bool:
        """Drive through poses; return whether the goal was taken."""
        goal = NavigateThroughPoses.Goal(behavior_tree=behavior_tree)
        goal.poses = type(goal.poses)(poses=poses) if hasattr(goal.poses, "poses") else poses
        return self._begin("navigate_through_poses", goal)

    def followWaypoints(self, poses: Any) -> bool:
        """Drive to poses one after another; return whether the goal was taken."""
        return self._begin("follow_waypoints", FollowWaypoints.Goal(poses=poses))

    def followPath(self, path: Any, controller_id: str = "", goal_checker_id: str = "") -> bool:
        """Follow a path; return whether the goal was taken."""
        goal = FollowPath.Goal(path=path)
        goal.controller_id, goal.goal_checker_id = controller_id, goal_checker_id
        return self._begin("follow_path", goal)

    def spin(self, spin_dist: float = 1.57, time_allowance: int = 10) -> bool:
        """Turn on the spot [rad]; return whether the goal was taken."""
        goal = Spin.Goal(target_yaw=float(spin_dist))
        return self._begin("spin", goal, time_allowance)

    def backup(
        self, backup_dist: float = 0.15, backup_speed: float = 0.025, time_allowance: int = 10
    ) -> bool:
        """Drive back [m, m/s]; return whether the goal was taken."""
        goal = BackUp.Goal(speed=float(backup_speed))
        goal.target.x = float(backup_dist)
        return self._begin("backup", goal, time_allowance)

    def driveOnHeading(
        self, dist: float = 0.15, speed: float = 0.025, time_allowance: int = 10
    ) -> bool:
        """Drive straight on [m, m/s]; return whether the goal was taken."""
        goal = DriveOnHeading.Goal(speed=float(speed))
        goal.target.x = float(dist)
        return self._begin("drive_on_heading", goal, time_allowance)

    def assistedTeleop(self, time_allowance: int = 30) -> bool:
        """Give the base to a user who drives; return whether the goal was taken."""
        goal = AssistedTeleop.Goal()
        return self._begin("assisted_teleop", goal, time_allowance)

    def cancelTask(self) -> None:
        """Cancel the task that goes on."""
        self.info("Canceling current task.")
        if self.result_future:
            rclpy.spin_until_future_complete(self, self.goal_handle.cancel_goal_async())

    def isTaskComplete(self) -> bool:
        """Return whether the task has ended; look at it for up to 0.1 s."""
        if not self.result_future:
            return True
        rclpy.spin_until_future_complete(self, self.result_future, timeout_sec=0.1)
        answer = self.result_future.result()
        if not answer:
            return False
        self.status = answer.status
        return True

    def getFeedback(self) -> Any:
        """Return the last feedback of the task."""
        return self.feedback

    def getResult(self) -> TaskResult:
        """Return what became of the task."""
        known = {
            GoalStatus.STATUS_SUCCEEDED: TaskResult.SUCCEEDED,
            GoalStatus.STATUS_ABORTED: TaskResult.FAILED,
            GoalStatus.STATUS_CANCELED: TaskResult.CANCELED,
        }
        return known.get(self.status, TaskResult.UNKNOWN)

    # Paths

    def getPath(
        self, start: Any, goal: Any, planner_id: str = "", use_start: bool = False
    ) -> Any | None:
        """Return a path between poses, None where none was found."""
        asked = ComputePathToPose.Goal(start=start, goal=goal, planner_id=planner_id)
        asked.use_start = use_start
        return self._path("compute_path_to_pose", asked, "path")

    def getPathThroughPoses(
        self, start: Any, goals: Any, planner_id: str = "", use_start: bool = False
    ) -> Any | None:
        """Return a path through poses, None where none was found."""
        asked = ComputePathThroughPoses.Goal(start=start, planner_id=planner_id)
        asked.goals = type(asked.goals)(poses=goals) if hasattr(asked.goals, "poses") else goals
        asked.use_start = use_start
        return self._path("compute_path_through_poses", asked, "path")

    def smoothPath(
        self,
        path: Any,
        smoother_id: str = "",
        max_duration: float = 2.0,
        check_for_collision: bool = False,
    ) -> Any | None:
        """Return a smoother path, None where there is none."""
        asked = SmoothPath.Goal(path=path, smoother_id=smoother_id)
        asked.max_smoothing_duration = Duration(seconds=max_duration).to_msg()
        asked.check_for_collisions = check_for_collision
        return self._path("smooth_path", asked, "path")

    def _path(self, name: str, goal: Any, field: str) -> Any | None:
        if not self._begin(name, goal):
            return None
        rclpy.spin_until_future_complete(self, self.result_future)
        answer = self.result_future.result()
        self.status = answer.status
        is_good = self.status == GoalStatus.STATUS_SUCCEEDED
        return getattr(answer.result, field) if is_good else None

    # Nav2 itself

    def waitUntilNav2Active(self, navigator: str = "bt_navigator", localizer: str = "amcl") -> None:
        """Wait until Nav2 is active, and knows where the base is."""
        if localizer != "robot_localization":
            self._wait_for_activation(localizer)
        if localizer == "amcl":
            self.localization_pose_sub = self.create_subscription(
                PoseWithCovarianceStamped, "amcl_pose", self._on_pose, self._localised
            )
            while not self.initial_pose_received:
                self._publish_initial_pose()
                rclpy.spin_once(self, timeout_sec=1.0)
        self._wait_for_activation(navigator)
        self.info("Nav2 is ready for use!")

    def _on_pose(self, message: Any) -> None:
        del message
        self.initial_pose_received = True

    def _wait_for_activation(self, node_name: str) -> None:
        client = self.create_client(GetState, f"{node_name}/get_state")
        while not client.wait_for_service(timeout_sec=1.0):
            self.info(f"{node_name}/get_state service not available, waiting...")
        while True:
            future = client.call_async(GetState.Request())
            rclpy.spin_until_future_complete(self, future)
            if future.result() is not None and future.result().current_state.label == "active":
                return
            time.sleep(2)

    def changeMap(self, map_filepath: str) -> None:
        """Load another map."""
        self._call("map_server/load_map", LoadMap.Request(map_url=map_filepath))

    def clearAllCostmaps(self) -> None:
        """Clear both maps of obstacles."""
        self.clearLocalCostmap()
        self.clearGlobalCostmap()

    def clearLocalCostmap(self) -> None:
        """Clear the map of obstacles around the base."""
        name = "local_costmap/clear_entirely_local_costmap"
        self._call(name, ClearEntireCostmap.Request())

    def clearGlobalCostmap(self) -> None:
        """Clear the map of obstacles of the whole place."""
        name = "global_costmap/clear_entirely_global_costmap"
        self._call(name, ClearEntireCostmap.Request())

    def lifecycleStartup(self) -> None:
        """Bring Nav2 up."""
        self._manage(ManageLifecycleNodes.Request.STARTUP)

    def lifecycleShutdown(self) -> None:
        """Take Nav2 down."""
        self._manage(ManageLifecycleNodes.Request.SHUTDOWN)

    def _manage(self, command: int) -> None:
        for name in _MANAGERS:
            self._call(name, ManageLifecycleNodes.Request(command=command))

    # The log

    def info(self, msg: str) -> None:
        """Log a message."""
        self.get_logger().info(msg)

    def warn(self, msg: str) -> None:
        """Log a warning."""
        self.get_logger().warn(msg)

    def error(self, msg: str) -> None:
        """Log an error."""
        self.get_logger().error(msg)

    def debug(self, msg: str) -> None:
        """Log a detail."""
        self.get_logger().debug(msg)

    # How

    def destroyNode(self) -> None:
        """Destroy the node."""
        self.destroy_node()

    def _begin(self, name: str, goal: Any, time_allowance: int | None = None) -> bool:
        if time_allowance is not None:
            goal.time_allowance = Duration(seconds=time_allowance).to_msg()
        kind = _ACTIONS[name]
        client = self._made.setdefault(name, None) or ActionClient(self, kind, name)
        self._made[name] = client
        while not client.wait_for_server(timeout_sec=1.0):
            self.info(f"'{kind.__name__}' action server not available, waiting...")
        future = client.send_goal_async(goal, self._on_feedback)
        rclpy.spin_until_future_complete(self, future)
        self.goal_handle = future.result()
        if not self.goal_handle.accepted:
            self.error(f"'{name}' request was rejected!")
            return False
        self.result_future = self.goal_handle.get_result_async()
        return True

    def _on_feedback(self, message: Any) -> None:
        self.feedback = message.feedback

    def _call(self, name: str, request: Any) -> Any:
        client = self._made.setdefault(name, None) or self.create_client(_SERVICES[name], name)
        self._made[name] = client
        while not client.wait_for_service(timeout_sec=1.0):
            self.info(f"{name} service not available, waiting...")
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        return future.result()
