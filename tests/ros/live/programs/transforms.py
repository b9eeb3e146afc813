import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped


def frame(parent, child, x):
    stamped = TransformStamped()
    stamped.header.stamp = rospy.Time.now()
    stamped.header.frame_id = parent
    stamped.child_frame_id = child
    stamped.transform.translation.x = x
    stamped.transform.rotation.w = 1.0
    return stamped


def main():
    rospy.init_node("transforms")
    buffer = tf2_ros.Buffer()
    tf2_ros.TransformListener(buffer)
    tf2_ros.StaticTransformBroadcaster().sendTransform(frame("panda_link0", "table", 0.5))
    rospy.sleep(0.5)
    broadcaster = tf2_ros.TransformBroadcaster()
    for step in range(5):
        broadcaster.sendTransform(frame("table", "cup", 0.1 * step))
        rospy.sleep(0.1)
    found = buffer.lookup_transform("panda_link0", "cup", rospy.Time(0), rospy.Duration(1.0))
    print("> cup", round(found.transform.translation.x, 3), found.header.frame_id)
    hand = buffer.lookup_transform("panda_link0", "panda_hand", rospy.Time(0), rospy.Duration(2.0))
    shift = hand.transform.translation
    # A zero has no sign here: it is the rest of a rounding.
    print("> hand", *(round(each, 2) + 0.0 for each in (shift.x, shift.y, shift.z)))
    print("> can", buffer.can_transform("panda_link0", "cup", rospy.Time(0)))
    print("> cannot", buffer.can_transform("panda_link0", "nowhere", rospy.Time(0)))
    for name, time in (("nowhere", rospy.Time(0)), ("cup", rospy.Time.now() + rospy.Duration(60))):
        try:
            buffer.lookup_transform("panda_link0", name, time, rospy.Duration(0.2))
        except tf2_ros.TransformException as error:
            print("> error", type(error).__name__)


if __name__ == "__main__":
    main()
