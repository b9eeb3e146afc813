import rospy
from std_msgs.msg import Empty


def main():
    rospy.set_param("/use_sim_time", True)  # by the clock of the wall a sleep goes on
    rospy.init_node("shutdown")
    rospy.on_shutdown(lambda: print("> hook one"))
    rospy.on_shutdown(lambda: print("> hook two", rospy.is_shutdown()))
    publisher = rospy.Publisher("/beat", Empty, queue_size=1)
    beats = []

    def beat(message):
        beats.append(message)
        if len(beats) == 3:
            rospy.signal_shutdown("enough")

    rospy.Subscriber("/beat", Empty, beat)
    rospy.sleep(0.3)
    rate = rospy.Rate(10)
    try:
        while not rospy.is_shutdown():
            publisher.publish()
            rate.sleep()
    except rospy.ROSInterruptException as error:
        print("> interrupted", type(error).__name__)
    print("> beats", len(beats), rospy.is_shutdown())
    rospy.spin()
    try:
        rospy.sleep(1.0)
    except rospy.ROSInterruptException:
        print("> no sleep")


if __name__ == "__main__":
    main()
