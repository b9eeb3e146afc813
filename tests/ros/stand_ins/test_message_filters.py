"""Synchronizers and caches, by the rules of ros_comm's message_filters."""

from __future__ import annotations


def program():
    import message_filters
    import rospy
    from geometry_msgs.msg import PointStamped
    from std_msgs.msg import String

    rospy.init_node("filters")

    def stamped(seconds: float) -> PointStamped:
        message = PointStamped()
        message.header.stamp = rospy.Time.from_sec(seconds)
        return message

    return message_filters, rospy, PointStamped, String, stamped


def test_equal_times_are_brought_together_in_their_order(run_node):
    def main():
        filters, _, _, _, stamped = program()
        left, right = filters.SimpleFilter(), filters.SimpleFilter()
        pairs = []
        sync = filters.TimeSynchronizer([left, right], 2)
        sync.registerCallback(
            lambda a, b, tag: pairs.append((a.header.stamp.secs, b.header.stamp.secs, tag)), "tag"
        )
        for seconds in (1, 2, 3):
            left.signalMessage(stamped(seconds))
        for seconds in (3, 1, 2):
            right.signalMessage(stamped(seconds))
        return pairs

    # Of the left only two are kept: that of 1 s was dropped.
    assert run_node(main) == [(3, 3, "tag"), (2, 2, "tag")]


def test_nearly_equal_times_are_brought_together_the_nearest_first(run_node):
    def main():
        filters, _, _, _, stamped = program()
        left, right = filters.SimpleFilter(), filters.SimpleFilter()
        pairs = []
        sync = filters.ApproximateTimeSynchronizer([left, right], 10, slop=0.1)
        sync.registerCallback(
            lambda a, b: pairs.append((a.header.stamp.to_sec(), b.header.stamp.to_sec()))
        )
        for seconds in (1.0, 1.06, 2.0):
            left.signalMessage(stamped(seconds))
        for seconds in (1.05, 2.2):
            right.signalMessage(stamped(seconds))
        return pairs

    assert run_node(main) == [(1.06, 1.05)]


def test_messages_without_a_stamp_need_leave(run_node, capsys):
    def main():
        filters, rospy, _, string, _ = program()
        plain, strict = filters.SimpleFilter(), filters.Cache(filters.SimpleFilter())
        strict.add(string("a"))
        cache = filters.Cache(plain, cache_size=3, allow_headerless=True)
        for text in "abcd":
            plain.signalMessage(string(text))
            rospy.sleep(0.1)
        return [m.data for m in cache.cache_msgs], strict.getLast(), cache.getLast().data

    assert run_node(main) == (["b", "c", "d"], None, "d")
    assert "non-stamped" in capsys.readouterr().err


def test_a_cache_is_asked_by_time(run_node):
    def main():
        filters, rospy, _, _, stamped = program()
        source = filters.SimpleFilter()
        cache = filters.Cache(source, 10)
        for seconds in (1.0, 2.0, 3.0):
            source.signalMessage(stamped(seconds))
        at = rospy.Time.from_sec
        return (
            [m.header.stamp.secs for m in cache.getInterval(at(1.5), at(3.0))],
            cache.getElemBeforeTime(at(2.5)).header.stamp.secs,
            cache.getElemAfterTime(at(2.5)).header.stamp.secs,
            cache.getElemAfterTime(at(3.5)),
            cache.getOldestTime().secs,
            cache.getLatestTime().secs,
        )

    assert run_node(main) == ([2, 3], 2, 3, None, 1, 3)


def test_topics_feed_filters(run_node):
    def main():
        filters, rospy, point, _, stamped = program()
        got = []
        subscribers = [filters.Subscriber(name, point, queue_size=5) for name in ("a", "b")]
        filters.TimeSynchronizer(subscribers, 5).registerCallback(lambda *pair: got.append(pair))
        senders = [rospy.Publisher(name, point, queue_size=5) for name in ("a", "b")]
        for sender in senders:
            sender.publish(stamped(7.0))
        rospy.sleep(0.1)
        return len(got), subscribers[0].getTopic(), subscribers[0].get_num_connections()

    assert run_node(main) == (1, "a", 1)
