import rospy
from std_msgs.msg import Int32, String


def main():
    rospy.init_node("latched")
    heard = []
    latched = rospy.Publisher("/note", String, latch=True, queue_size=1)
    latched.publish("early")
    latched.publish("late")
    plain = rospy.Publisher("/count", Int32, queue_size=10)
    plain.publish(1)
    rospy.Subscriber("/note", String, lambda m: heard.append(("note", m.data)))
    subscriber = rospy.Subscriber(
        "/count", Int32, lambda m, tag: heard.append((tag, m.data)), "tag"
    )
    rospy.sleep(0.5)
    for value in (2, 3, 4):
        plain.publish(value)
    plain.publish(data=5)
    rospy.sleep(0.2)
    try:
        plain.publish("word")
    except rospy.ROSException as error:
        print("> refused", type(error).__name__)
    except Exception as error:
        print("> refused", type(error).__name__)
    subscriber.unregister()
    rospy.sleep(0.2)
    plain.publish(6)
    rospy.sleep(0.2)
    rospy.Subscriber("/note", String, lambda m: heard.append(("again", m.data)))
    rospy.sleep(0.2)
    print("> notes", [h for h in heard if h[0] != "tag"])
    print("> counts", [h[1] for h in heard if h[0] == "tag"])
    print("> connections", latched.get_num_connections())


if __name__ == "__main__":
    main()
