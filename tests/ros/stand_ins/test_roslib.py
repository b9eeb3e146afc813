"""The master, addresses and names of `rosgraph` and `roslib`, and rospy's checks of names."""

import io
import socket
import struct

import pytest


def test_calls_of_the_master_name_the_caller_and_unpack_the_reply(run_node):
    def main():
        import rosgraph

        master = rosgraph.Master("/cell")
        master.setParam("/speed", 0.5)
        found = master.getParam("/speed"), master.is_online(), master.getPid()
        with pytest.raises(rosgraph.MasterError, match="not set"):
            master.getParam("/none")

        class Other:
            def registerPublisher(self, *arguments):  # noqa: N802 - its name in ROS
                self.called = arguments
                return 1, "", ["http://cell:1234"]

        with pytest.raises(AttributeError, match="has no registerPublisher"):
            master.registerPublisher("/a", "std_msgs/String", "http://localhost:1")
        master.handle = Other()
        answer = master.registerPublisher("/a", "std_msgs/String", "http://localhost:1")
        return found, answer, master.handle.called

    found, answer, called = run_node(main)
    assert found == (0.5, True, 1)
    assert answer == ["http://cell:1234"]
    assert called == ("/cell", "/a", "std_msgs/String", "http://localhost:1")


def test_no_master_but_that_of_the_run_is_online(run_node, monkeypatch):
    monkeypatch.setenv("ROS_MASTER_URI", "http://cell:11311")

    def main():
        import rosgraph

        uris = (None, "http://cell:11311/", "http://localhost:11311", "http://other:11311", "")
        return [rosgraph.is_master_online(uri) for uri in uris]

    assert run_node(main) == [True, True, True, False, False]


def test_addresses_are_those_of_the_environment_or_of_loopback(run_node, monkeypatch):
    monkeypatch.delenv("ROS_IP", raising=False)
    monkeypatch.delenv("ROS_HOSTNAME", raising=False)

    def addresses():
        from rosgraph import network

        return network.get_local_address(), network.get_bind_address(), network.get_host_name()

    assert run_node(addresses) == ("127.0.0.1", "0.0.0.0", "127.0.0.1")
    assert run_node(addresses, "__ip:=10.0.0.1") == ("10.0.0.1", "0.0.0.0", "10.0.0.1")
    monkeypatch.setenv("ROS_HOSTNAME", "localhost")
    assert run_node(addresses) == ("localhost", "127.0.0.1", "localhost")


def test_headers_of_connections_are_read_as_they_were_written(run_node):
    def main():
        from rosgraph import network

        ours, theirs = socket.socketpair()
        with ours, theirs:
            network.write_ros_handshake_header(ours, {"topic": "/a", "type": "std_msgs/String"})
            ours.sendall(b"more")
            rest = io.BytesIO()
            found = network.read_ros_handshake_header(theirs, rest, 4096)
        for broken in (struct.pack("<I", 9), struct.pack("<II", 9, 5) + b"field"):
            with pytest.raises(network.ROSHandshakeException):
                network.decode_ros_handshake_header(broken)
        return found, rest.getvalue()

    assert run_node(main) == ({"topic": "/a", "type": "std_msgs/String"}, b"more")


def test_checks_of_names_resolve_them_or_say_what_is_wrong(run_node):
    def main():
        import rospy
        from rospy.impl.validators import non_empty
        from rospy.names import global_name, valid_name

        assert valid_name("topic")("~name", "/ns/node") == "/ns/node/name"
        assert valid_name("topic", False)("~name", "/node") == "~name"
        assert global_name("topic")("/name", "/node") == "/name"
        assert rospy.core.is_topic("topic")("name", "/ns/node") == "/ns/name"
        assert non_empty("topic")("name", "") == "name"
        for check, value in (
            (valid_name("topic"), "http://cell"),
            (valid_name("topic", False), 1),
            (global_name("topic"), "name"),
            (rospy.core.is_topic("topic"), "/"),
            (non_empty("topic"), ""),
        ):
            with pytest.raises(rospy.core.ParameterInvalid, match=r"parameter \[topic\]"):
                check(value, "/node")

    run_node(main)


def test_resources_of_packages_have_two_parts(run_node):
    def main():
        import roslib.names

        assert roslib.names.package_resource_name("std_msgs/String") == ("std_msgs", "String")
        assert roslib.names.package_resource_name("String") == ("", "String")
        with pytest.raises(ValueError, match="a/b/c"):
            roslib.names.package_resource_name("a/b/c")

    run_node(main)


def test_messages_go_over_a_connection_one_behind_the_other(run_node):
    def main():
        import genpy
        import rospy
        from rospy.msg import deserialize_messages, serialize_message
        from std_msgs.msg import Header, String

        buffer = io.BytesIO()
        for number in range(4):
            serialize_message(buffer, number, String(str(number)))
        whole = buffer.tell()
        buffer.write(struct.pack("<I", 100) + b"cut")
        first: list = []
        deserialize_messages(buffer, first, String, max_msgs=1)
        rest: list = []
        deserialize_messages(buffer, rest, String, queue_size=2)
        assert [each.data for each in (*first, *rest)] == ["0", "2", "3"]
        assert buffer.getvalue() == struct.pack("<I", 100) + b"cut"
        assert whole == 4 * 9
        broken = io.BytesIO()
        broken.write(struct.pack("<I", 2) + b"ab")
        with pytest.raises(genpy.DeserializationError):
            deserialize_messages(broken, [], String)
        header = Header(0, rospy.Time(1), "")
        header.frame_id = None
        from geometry_msgs.msg import PoseStamped

        serialize_message(io.BytesIO(), 7, PoseStamped(header=header))
        assert (header.seq, header.frame_id) == (7, "0")

    run_node(main)


def test_packages_are_attributes_of_ros(run_node):
    def main():
        import ros
        from ros import rospy

        with pytest.raises(AttributeError, match="module 'ros' has no attribute 'nope'"):
            _ = ros.nope
        return rospy.__name__, ros.std_msgs.__name__

    assert run_node(main) == ("rospy", "std_msgs")
