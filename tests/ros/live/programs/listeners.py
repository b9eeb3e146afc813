import rospy
from std_msgs.msg import String


class Listener(rospy.SubscribeListener):
    def __init__(self):
        super().__init__()
        self.events = []

    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        self.events.append(("in", topic_name))
        peer_publish(String("welcome"))

    def peer_unsubscribe(self, topic_name, num_peers):
        self.events.append(("out", topic_name, num_peers))


def main():
    rospy.init_node("listeners")
    listener = Listener()
    publisher = rospy.Publisher("/talk", String, subscriber_listener=listener, queue_size=5)
    heard, raw = [], []
    first = rospy.Subscriber("/talk", String, lambda m: heard.append(m.data))
    rospy.sleep(0.3)
    rospy.Subscriber("/talk", rospy.AnyMsg, lambda m: raw.append(m._type))
    rospy.sleep(0.3)
    publisher.publish("hello")
    rospy.sleep(0.3)
    first.unregister()
    rospy.sleep(0.3)
    print("> heard", heard)
    print("> raw", raw)
    print("> events", sorted({e[0] for e in listener.events}))
    print("> topics", [t for t in rospy.get_published_topics() if t[0] == "/talk"])
    print("> type", first.type, publisher.type, publisher.resolved_name)


if __name__ == "__main__":
    main()
