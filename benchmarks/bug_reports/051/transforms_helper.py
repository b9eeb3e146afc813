"""Positions of frames."""
import rospy
import tf2_ros

buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)


def position(target, source):
    transform = buffer.lookup_transform(target, source, rospy.Time(0), rospy.Duration(2.0))
    translation = transform.transform.translation
    return [round(value, 3) for value in (translation.x, translation.y, translation.z)]
