import message_filters
import rospy
from geometry_msgs.msg import PointStamped


def stamped(seconds, x):
    message = PointStamped()
    message.header.stamp = rospy.Time(seconds, 0)
    message.point.x = x
    return message


def main():
    rospy.init_node("filters")
    exact, near, plain = [], [], []
    left = message_filters.Subscriber("/left", PointStamped)
    right = message_filters.Subscriber("/right", PointStamped)
    message_filters.TimeSynchronizer([left, right], 10).registerCallback(
        lambda a, b: exact.append((a.point.x, b.point.x))
    )
    message_filters.ApproximateTimeSynchronizer([left, right], 10, 1.5).registerCallback(
        lambda a, b: near.append((a.point.x, b.point.x))
    )
    cache = message_filters.Cache(left, 3)
    left.registerCallback(lambda m: plain.append(m.point.x))
    publishers = [rospy.Publisher(n, PointStamped, queue_size=10) for n in ("/left", "/right")]
    rospy.sleep(0.5)
    for seconds in (10, 20, 30, 40):
        publishers[0].publish(stamped(seconds, float(seconds)))
        rospy.sleep(0.1)
    for seconds in (10, 21, 30):
        publishers[1].publish(stamped(seconds, -float(seconds)))
        rospy.sleep(0.1)
    print("> exact", exact)
    print("> near", near)
    print("> plain", plain)
    print("> cache", [m.point.x for m in cache.getInterval(rospy.Time(15), rospy.Time(35))])
    print("> newest", cache.getLatestTime().to_sec(), cache.getOldestTime().to_sec())
    print("> after", cache.getElemAfterTime(rospy.Time(25)).point.x)


if __name__ == "__main__":
    main()
