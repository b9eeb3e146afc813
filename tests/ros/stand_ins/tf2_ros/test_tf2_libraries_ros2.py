"""tf2 of ROS 2: clouds, signs of turns, words of failures, buffers of others, stamps that are Times.

Sources: ros2/geometry2 (branch rolling, commit 1b005c65) `tf2/src/cache.cpp`,
`tf2_ros_py/tf2_ros/buffer_client.py`, `tf2_geometry_msgs`, `tf2_sensor_msgs`.
"""

import pytest


def test_a_cloud_is_moved_and_its_other_fields_stay(run_ros2):
    def main():
        import numpy as np
        import tf2_ros
        from geometry_msgs.msg import Transform, TransformStamped
        from sensor_msgs.msg import PointField
        from sensor_msgs_py.point_cloud2 import create_cloud, read_points_numpy
        from std_msgs.msg import Header
        from tf2_sensor_msgs import do_transform_cloud, transform_points

        fields = [
            PointField(name=name, offset=4 * at, datatype=PointField.FLOAT32, count=1)
            for at, name in enumerate("xyza")
        ]
        given = np.array([[1, 2, 3, 9], [4, 5, 6, 8]], np.float32)
        cloud = create_cloud(Header(frame_id="eye"), fields, given)
        half_turn = Transform()
        half_turn.translation.z = 10.0
        half_turn.rotation.x, half_turn.rotation.w = 1.0, 0.0
        moved = do_transform_cloud(cloud, half_turn)
        placed = TransformStamped(child_frame_id="base")
        placed.header.frame_id = "eye"
        placed.transform.translation.x = 1.0
        buffer = tf2_ros.Buffer()
        buffer.set_transform_static(placed, "test")
        seen = buffer.transform(cloud, "base")
        assert np.array_equal(read_points_numpy(cloud), given)
        assert np.allclose(transform_points(given[:, :3], half_turn), [[1, -2, 7], [4, -5, 4]])
        return (
            (moved.header.frame_id, read_points_numpy(moved).tolist()),
            (seen.header.frame_id, read_points_numpy(seen)[:, 0].tolist()),
        )

    assert run_ros2(main) == (
        ("eye", [[1.0, -2.0, 7.0, 9.0], [4.0, -5.0, 4.0, 8.0]]),
        ("base", [0.0, 3.0]),
    )


def test_a_pose_turns_with_a_positive_w_and_failures_say_no_span(run_ros2):
    def main():
        import tf2_geometry_msgs
        import tf2_py
        from geometry_msgs.msg import PoseStamped, TransformStamped
        from rclpy.time import Time

        half_turn = TransformStamped()
        half_turn.transform.rotation.x, half_turn.transform.rotation.w = 1.0, 0.0
        pose = PoseStamped()
        pose.pose.orientation.x, pose.pose.orientation.w = 1.0, 0.0
        turned = tf2_geometry_msgs.do_transform_pose_stamped(pose, half_turn).pose.orientation

        core = tf2_py.BufferCore()
        for sec in (1, 2):
            placed = TransformStamped(child_frame_id="hand")
            placed.header.frame_id = "base"
            placed.header.stamp.sec = sec
            core.set_transform(placed, "test")
        reported = []
        for seconds in (0.5, 2.5):
            with pytest.raises(tf2_py.ExtrapolationException) as failed:
                core.lookup_transform_core("base", "hand", Time(seconds=seconds))
            reported.append(str(failed.value).partition(".")[0])
        return turned.w, reported

    words = "Lookup would require extrapolation into the"
    assert run_ros2(main) == (1.0, [f"{words} past", f"{words} future"])


def test_a_buffer_client_raises_what_the_server_says_even_if_the_goal_was_aborted(run_ros2):
    def main():
        from threading import Thread

        import rclpy
        import tf2_py
        from rclpy.action import ActionServer
        from rclpy.time import Time
        from tf2_msgs.action import LookupTransform
        from tf2_ros.buffer_client import BufferClient

        def execute(handle):
            handle.abort()
            result = LookupTransform.Result()
            result.error.error = result.error.LOOKUP_ERROR
            result.error.error_string = "no such frame"
            return result

        rclpy.init()
        node = rclpy.create_node("arm")
        ActionServer(node, LookupTransform, "frames", execute)
        Thread(target=rclpy.spin, args=(node,), daemon=True).start()
        with pytest.raises(tf2_py.LookupException, match="no such frame"):
            BufferClient(node, "frames").lookup_transform("a", "b", Time())

    run_ros2(main)


def test_filters_take_stamps_that_are_times_already(run_ros2):
    def main():
        from types import SimpleNamespace

        from message_filters import ApproximateTimeSynchronizer, SimpleFilter
        from rclpy.time import Time

        pairs, left, right = [], SimpleFilter(), SimpleFilter()
        ApproximateTimeSynchronizer([left, right], 5, 0.2).registerCallback(
            lambda *pair: pairs.append(pair)
        )
        for each, seconds in ((left, 1.0), (right, 1.1), (right, 3.0)):
            stamp = Time(seconds=seconds)
            each.signalMessage(SimpleNamespace(header=SimpleNamespace(stamp=stamp)))
        return len(pairs)

    assert run_ros2(main) == 1
