"""Lookups by numbers, and messages into other frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import (
    Point,
    PointStamped,
    Pose,
    PoseStamped,
    Quaternion,
    QuaternionStamped,
    Vector3,
    Vector3Stamped,
)
from sensor_msgs.msg import PointCloud

from tracerisk.ros.graph.failures import lookup_failed, lookup_succeeded

from . import transformations

Numbers = list[float]


def xyz_to_mat44(pos: Any) -> Any:
    """Return a point as a translation: (4, 4)."""
    return transformations.translation_matrix((pos.x, pos.y, pos.z))


def xyzw_to_mat44(ori: Any) -> Any:
    """Return a quaternion as a rotation: (4, 4)."""
    return transformations.quaternion_matrix((ori.x, ori.y, ori.z, ori.w))


def strip_leading_slash(s: str) -> str:
    """Return a frame's name as tf2 wants it."""
    return s.removeprefix("/")


class Transformer:
    """Keeps transforms and answers in lists: [x, y, z] and [qx, qy, qz, qw]."""

    def __init__(self, interpolate: bool = True, cache_time: Any = None) -> None:
        self._buffer = tf2_ros.Buffer(cache_time, debug=False)
        self._using_dedicated_thread = False

    def allFramesAsDot(self, current_time: Any = None) -> str:
        """Return the tree of frames in the DOT language."""
        return str(self._buffer._allFramesAsDot(current_time))

    def allFramesAsString(self) -> str:
        """Return a sentence for each frame."""
        return str(self._buffer.all_frames_as_string())

    def setTransform(self, transform: Any, authority: str = "default_authority") -> None:
        """Note a TransformStamped."""
        self._buffer.set_transform(transform, authority)

    def canTransform(self, target_frame: str, source_frame: str, time: Any) -> bool:
        """Return whether a lookup would be answered."""
        target, source = _stripped(target_frame, source_frame)
        return bool(self._buffer.can_transform(target, source, time))

    def canTransformFull(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
    ) -> bool:
        """Return whether a lookup between two times would be answered."""
        target, source, fixed = _stripped(target_frame, source_frame, fixed_frame)
        return bool(
            self._buffer.can_transform_full(target, target_time, source, source_time, fixed)
        )

    def waitForTransform(
        self,
        target_frame: str,
        source_frame: str,
        time: Any,
        timeout: Any,
        polling_sleep_duration: Any = None,
    ) -> None:
        """Wait until there is a transform.

        Raises:
            tf.Exception: there is none at the end of the timeout.
        """
        self._check_thread()
        target, source = _stripped(target_frame, source_frame)
        answer = self._buffer.can_transform(target, source, time, timeout, return_debug_tuple=True)
        _raise_unless(answer, target_frame, source_frame)

    def waitForTransformFull(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any,
        polling_sleep_duration: Any = None,
    ) -> None:
        """Wait until there is a transform between two times.

        Raises:
            tf.Exception: there is none at the end of the timeout.
        """
        self._check_thread()
        target, source, fixed = _stripped(target_frame, source_frame, fixed_frame)
        answer = self._buffer.can_transform_full(
            target, target_time, source, source_time, fixed, timeout, return_debug_tuple=True
        )
        _raise_unless(answer, target_frame, source_frame)

    def chain(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
    ) -> list[str]:
        """Return the frames on the way from source to target."""
        chain: list[str] = self._buffer._chain(
            target_frame, target_time, source_frame, source_time, fixed_frame
        )
        return chain

    def clear(self) -> None:
        """Forget every transform."""
        self._buffer.clear()

    def frameExists(self, frame_id: str) -> bool:
        """Return whether a frame has a parent."""
        return frame_id in self.getFrameStrings()

    def getFrameStrings(self) -> list[str]:
        """Return the frames that have a parent."""
        tree = self._buffer._tree
        return [frame for frame in tree.frames if tree.parent(frame) is not None]

    def getLatestCommonTime(self, source_frame: str, dest_frame: str) -> Any:
        """Return the latest time at which the whole way between two frames is known."""
        source, target = _stripped(source_frame, dest_frame)
        return self._buffer.get_latest_common_time(source, target)

    def lookupTransform(
        self, target_frame: str, source_frame: str, time: Any
    ) -> tuple[Numbers, Numbers]:
        """Return where source is in target: position [m] and quaternion.

        Raises:
            LookupException, ConnectivityException, ExtrapolationException: there is none.
        """
        target, source = _stripped(target_frame, source_frame)
        return _as_lists(self._buffer.lookup_transform(target, source, time))

    def lookupTransformFull(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
    ) -> tuple[Numbers, Numbers]:
        """Return where source was at one time in target at another; see `lookupTransform`."""
        target, source, fixed = _stripped(target_frame, source_frame, fixed_frame)
        return _as_lists(
            self._buffer.lookup_transform_full(target, target_time, source, source_time, fixed)
        )

    def lookupTwist(
        self, tracking_frame: str, observation_frame: str, time: Any, averaging_interval: Any
    ) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return the mean velocity of a frame [m/s], [rad/s]; see `lookupTwistFull`."""
        return self.lookupTwistFull(
            tracking_frame,
            observation_frame,
            observation_frame,
            (0, 0, 0),
            tracking_frame,
            time,
            averaging_interval,
        )

    def lookupTwistFull(
        self,
        tracking_frame: str,
        observation_frame: str,
        reference_frame: str,
        ref_point: Sequence[float],
        reference_point_frame: str,
        time: Any,
        averaging_interval: Any,
    ) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return the mean velocity of `tracking_frame`, seen from `observation_frame`.

        In the axes of `reference_frame`, at `ref_point` of `reference_point_frame`, over an
        interval about `time`: linear [m/s] and angular [rad/s].
        """
        latest = self.getLatestCommonTime(observation_frame, tracking_frame)
        target_time = time or latest
        half = rospy.Duration(0.5 * averaging_interval.to_sec())
        end = min(target_time + half, latest)
        start = max(rospy.Time(0.0001) + averaging_interval, end) - averaging_interval
        span_s = (end - start).to_sec()
        from_place, from_turn = self.lookupTransform(observation_frame, tracking_frame, start)
        to_place, to_turn = self.lookupTransform(observation_frame, tracking_frame, end)
        back = transformations.quaternion_inverse(from_turn)
        change = transformations.quaternion_multiply(to_turn, back)
        angular = _rotation_vector(change) / span_s
        linear = np.subtract(to_place, from_place) / span_s
        # Velocities are those of the tracked frame's origin, in the axes of observation.
        axes = self._rotation(reference_frame, observation_frame, target_time)
        origin, _ = self.lookupTransform(reference_frame, tracking_frame, target_time)
        point = self.fromTranslationRotation(
            *self.lookupTransform(reference_frame, reference_point_frame, target_time)
        ) @ np.array([*ref_point, 1.0])
        turning = axes @ angular
        moving = axes @ linear + np.cross(turning, point[:3] - np.array(origin))
        return tuple(moving.tolist()), tuple(turning.tolist())

    def setUsingDedicatedThread(self, value: bool) -> None:
        """Set whether something fills the buffer while the program waits."""
        self._using_dedicated_thread = value

    def getTFPrefix(self) -> str:
        """Return the prefix of frames; tf2 has none."""
        return ""

    def fromTranslationRotation(
        self, translation: Sequence[float], rotation: Sequence[float]
    ) -> Any:
        """Return position and quaternion as a matrix: (4, 4)."""
        return np.dot(
            transformations.translation_matrix(translation),
            transformations.quaternion_matrix(rotation),
        )

    def _rotation(self, target_frame: str, source_frame: str, time: Any) -> Any:
        _, turn = self.lookupTransform(target_frame, source_frame, time)
        return transformations.quaternion_matrix(turn)[:3, :3]

    def _check_thread(self) -> None:
        if not self._using_dedicated_thread:
            raise tf2_ros.TransformException(
                "cannot wait for transform without a dedicated thread that listens to incoming "
                "TF messages"
            )


class TransformerROS(Transformer):
    """Brings stamped messages into other frames."""

    def asMatrix(self, target_frame: str, hdr: Any) -> Any:
        """Return the transform from a header's frame at its time as a matrix: (4, 4)."""
        return self.fromTranslationRotation(
            *self.lookupTransform(target_frame, hdr.frame_id, hdr.stamp)
        )

    def transformPoint(self, target_frame: str, ps: Any) -> Any:
        """Return a PointStamped in another frame."""
        x, y, z = _moved(self.asMatrix(target_frame, ps.header), ps.point)
        return _headed(PointStamped(point=Point(x=x, y=y, z=z)), ps, target_frame)

    def transformVector3(self, target_frame: str, v3s: Any) -> Any:
        """Return a Vector3Stamped in another frame: turned, not shifted."""
        matrix = self.asMatrix(target_frame, v3s.header)
        matrix[:3, 3] = 0.0
        x, y, z = _moved(matrix, v3s.vector)
        return _headed(Vector3Stamped(vector=Vector3(x=x, y=y, z=z)), v3s, target_frame)

    def transformQuaternion(self, target_frame: str, ps: Any) -> Any:
        """Return a QuaternionStamped in another frame."""
        matrix = np.dot(self.asMatrix(target_frame, ps.header), xyzw_to_mat44(ps.quaternion))
        return _headed(QuaternionStamped(quaternion=_turn_of(matrix)), ps, target_frame)

    def transformPose(self, target_frame: str, ps: Any) -> Any:
        """Return a PoseStamped in another frame."""
        given = np.dot(xyz_to_mat44(ps.pose.position), xyzw_to_mat44(ps.pose.orientation))
        matrix = np.dot(self.asMatrix(target_frame, ps.header), given)
        x, y, z = transformations.translation_from_matrix(matrix).tolist()
        pose = Pose(position=Point(x=x, y=y, z=z), orientation=_turn_of(matrix))
        return _headed(PoseStamped(pose=pose), ps, target_frame)

    def transformPointCloud(self, target_frame: str, point_cloud: Any) -> Any:
        """Return a PointCloud in another frame."""
        matrix = self.asMatrix(target_frame, point_cloud.header)
        cloud = PointCloud(channels=point_cloud.channels)
        for point in point_cloud.points:
            moved = type(point)()
            moved.x, moved.y, moved.z = _moved(matrix, point)
            cloud.points.append(moved)
        return _headed(cloud, point_cloud, target_frame)


class TransformListener(TransformerROS):
    """Listens to `/tf` and `/tf_static`."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._listener = tf2_ros.TransformListener(self._buffer)
        self.setUsingDedicatedThread(True)


def _stripped(*frames: str) -> tuple[str, ...]:
    return tuple(strip_leading_slash(frame) for frame in frames)


def _raise_unless(answer: tuple[bool, str], target: str, source: str) -> None:
    can_transform, reason = answer
    if can_transform:
        lookup_succeeded((source, target))
    else:
        lookup_failed(f"tf look-up of frame '{source}' in '{target}' failed", source)
        raise tf2_ros.TransformException(
            reason or f'no such transformation: "{source}" -> "{target}"'
        )


def _as_lists(message: Any) -> tuple[Numbers, Numbers]:
    shift, turn = message.transform.translation, message.transform.rotation
    return [shift.x, shift.y, shift.z], [turn.x, turn.y, turn.z, turn.w]


def _moved(matrix: Any, point: Any) -> Numbers:
    moved: Numbers = np.dot(matrix, np.array([point.x, point.y, point.z, 1.0]))[:3].tolist()
    return moved


def _turn_of(matrix: Any) -> Any:
    x, y, z, w = transformations.quaternion_from_matrix(matrix).tolist()
    return Quaternion(x=x, y=y, z=z, w=w)


def _headed(message: Any, given: Any, frame: str) -> Any:
    message.header.stamp = given.header.stamp
    message.header.frame_id = frame
    return message


def _rotation_vector(turn: Any) -> Any:
    """Return axis times angle of the shorter turn [rad]: (3,)."""
    turn = np.copysign(1.0, turn[3]) * np.asarray(turn)
    sine = float(np.linalg.norm(turn[:3]))
    if sine < 1e-12:
        return 2.0 * turn[:3]
    return turn[:3] / sine * 2.0 * np.arctan2(sine, turn[3])
