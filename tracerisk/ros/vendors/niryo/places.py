"""The poses and frames that a Niryo arm remembers by name, for one run.

Source: NiryoRobotics/ned_ros, niryo_robot_poses_handlers (srv, scripts/poses_handlers_node.py).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.ros.moveit.messages import set_pose
from tracerisk.ros.moveit.path_constraints import message_pose
from tracerisk.ros.robot.frames import set_transform
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import TwinNode
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.ros.transforms.poses import rpy_from_quaternion
from tracerisk.twin.physics.motion import Pose

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

PACKAGE = "niryo_robot_poses_handlers"

_NODE = "/niryo_robot_poses_handlers"
_SUCCESS = 1
_CREATION_FAILED, _REMOVAL_FAILED, _READ_FAILURE = -300, -301, -302
_FRAME_MISSING, _FRAME_EDIT_FAILED, _FRAME_CREATION_FAILED = -304, -305, -306
_SAVE, _SAVE_WITH_POINTS, _EDIT, _DELETE = 1, 2, 3, -1

Handler = Callable[[Any, Any], tuple[int, str] | None]


class NiryoPlaces(TwinNode):
    """Keeps poses and dynamic frames; a frame is published from `world` on /tf_static."""

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._poses: dict[str, Any] = {}
        self._frames: dict[str, Any] = {}
        self._transforms: Any = None

    def _services_of_places(self) -> Mapping[str, tuple[str, Handler]]:
        return {
            "manage_pose": (f"{PACKAGE}/ManagePose", self._manage_pose),
            "get_pose": (f"{PACKAGE}/GetPose", self._get_pose),
            "manage_dynamic_frame": (f"{PACKAGE}/ManageDynamicFrame", self._manage_frame),
            "get_dynamic_frame": (f"{PACKAGE}/GetDynamicFrame", self._get_frame),
        }

    def _listed(self, known: Mapping[str, Any], message: Any) -> Any:
        for name, item in sorted(known.items()):
            entry = self._messages.new("niryo_robot_msgs/BasicObject")
            entry.name, entry.description = name, item.description
            message.objects.append(entry)
        return message

    def _manage_pose(self, request: Any, answer: Any) -> tuple[int, str]:
        del answer
        name = request.pose.name
        if request.cmd == _SAVE:
            self._poses[name] = request.pose
            return _SUCCESS, f"Created pose '{name}'"
        if request.cmd == _DELETE and name in self._poses:
            del self._poses[name]
            return _SUCCESS, f"Removed pose '{name}'"
        if request.cmd == _DELETE:
            return _REMOVAL_FAILED, _unknown("pose", name, self._poses)
        return _CREATION_FAILED, f"cmd {request.cmd}; allowed: 1 (save), -1 (delete)"

    def _get_pose(self, request: Any, answer: Any) -> tuple[int, str]:
        if request.name not in self._poses:
            return _READ_FAILURE, _unknown("pose", request.name, self._poses)
        answer.pose = self._poses[request.name]
        return _SUCCESS, "Success"

    def _manage_frame(self, request: Any, answer: Any) -> tuple[int, str]:
        del answer
        frame = request.dynamic_frame
        if request.cmd in (_SAVE, _SAVE_WITH_POINTS):
            points = frame.points
            if request.cmd == _SAVE:
                points = [pose.position for pose in frame.poses]
            return self._save(frame, points)
        if frame.name not in self._frames:
            return _FRAME_MISSING, _unknown("dynamic frame", frame.name, self._frames)
        if request.cmd == _DELETE:
            del self._frames[frame.name]
            return _SUCCESS, f"Removed dynamic frame '{frame.name}'"
        if request.cmd == _EDIT:
            known = self._frames.pop(frame.name)
            known.name, known.description = frame.new_name or frame.name, frame.description
            self._frames[known.name] = known
            self._publish()
            return _SUCCESS, f"Dynamic frame '{known.name}' edited"
        return _FRAME_EDIT_FAILED, f"cmd {request.cmd}; allowed: 1, 2, 3 and -1"

    def _save(self, frame: Any, points: Any) -> tuple[int, str]:
        if len(points) != 3:
            return _FRAME_CREATION_FAILED, f"{len(points)} points; a frame has origin, x and y"
        origin, x, y = (np.array((point.x, point.y, point.z)) for point in points)
        pose = _frame(origin, x, y)
        if pose is None:
            return _FRAME_CREATION_FAILED, "the points of the frame lie on one line"
        self._frames[frame.name] = filled(frame, pose)
        self._publish()
        return _SUCCESS, f"Created dynamic frame '{frame.name}'"

    def _get_frame(self, request: Any, answer: Any) -> tuple[int, str]:
        if request.name not in self._frames:
            return _FRAME_MISSING, _unknown("dynamic frame", request.name, self._frames)
        answer.dynamic_frame = self._frames[request.name]
        return _SUCCESS, "Success"

    def _publish(self) -> None:
        if self._transforms is None:
            self._transforms = self._graph.advertise(
                "/tf_static", "tf2_msgs/TFMessage", node=_NODE, latch=True, by_controller=False
            )
        message = self._messages.new("tf2_msgs/TFMessage")
        for name, frame in sorted(self._frames.items()):
            transform = self._messages.new("geometry_msgs/TransformStamped")
            now_ns = EPOCH_NS + self._scheduler.now_ns
            set_transform(transform, "world", name, message_pose(frame), now_ns)
            message.transforms.append(transform)
        self._transforms.publish(message)


def filled(message: Any, pose: Pose) -> Any:
    """Write a pose into a message that has its turns twice."""
    set_pose(message, pose)
    rpy = message.rpy
    rpy.roll, rpy.pitch, rpy.yaw = rpy_from_quaternion(pose.orientation)
    return message


def _unknown(kind: str, name: str, known: Mapping[str, Any]) -> str:
    return f"no {kind} '{name}'; known: {', '.join(sorted(known)) or 'none'}"


def _frame(origin: Any, on_x: Any, near_y: Any) -> Pose | None:
    """Return the frame with x through a point and y towards another, None for points in line."""
    along = on_x - origin
    normal = np.cross(along, near_y - origin)
    if np.linalg.norm(normal) < 1e-9:
        return None
    x, z = along / np.linalg.norm(along), normal / np.linalg.norm(normal)
    matrix = np.column_stack((x, np.cross(z, x), z))
    a, b, c = (float(item) for item in origin)
    return Pose((a, b, c), _quaternion(matrix))


def _quaternion(m: Any) -> tuple[float, float, float, float]:
    # The eigenvector to the largest eigenvalue (Bar-Itzhack, 2000): no case is ill-conditioned.
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], 0, 0, 0],
            [m[0, 1] + m[1, 0], m[1, 1] - m[0, 0] - m[2, 2], 0, 0],
            [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], m[2, 2] - m[0, 0] - m[1, 1], 0],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], m[0, 0] + m[1, 1] + m[2, 2]],
        ]
    )
    values, vectors = np.linalg.eigh(k)
    x, y, z, w = (float(item) for item in vectors[:, int(np.argmax(values))])
    return (x, y, z, w)
