import rospy


def main():
    rospy.init_node("rates")
    rate = rospy.Rate(10)
    start = rospy.Time.now()
    for _ in range(5):
        rate.sleep()
    print("> five", round((rospy.Time.now() - start).to_sec(), 1))
    rospy.sleep(0.25)
    print("> behind", rate.remaining() < rospy.Duration(0))
    rate.sleep()
    print("> caught up", round((rospy.Time.now() - start).to_sec(), 1))
    rospy.sleep(rospy.Duration(0, 300_000_000))
    print("> slept", round((rospy.Time.now() - start).to_sec(), 1))
    later = start + rospy.Duration.from_sec(2.5)
    print("> time", (later - start).to_sec(), later > start, rospy.Time(3, 5).to_nsec())
    print("> seconds", abs(rospy.get_time() - rospy.Time.now().to_sec()) < 0.05)
    print("> nothing", rospy.Time(), rospy.Duration(1.5), rospy.Duration(1, 5) / 2)
    rospy.sleep(-1.0)
    try:
        rospy.Rate(0)
    except Exception as error:
        print("> no rate", type(error).__name__)


if __name__ == "__main__":
    main()
