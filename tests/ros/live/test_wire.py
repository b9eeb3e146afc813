"""Bytes of messages are compared by what they hold, in either version of ROS."""

import pytest

from tracerisk.ros.live.wire import wire_of
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2


@pytest.fixture(params=[Interfaces, Interfaces2])
def interfaces(request):
    return request.param()


def test_a_message_is_read_as_it_was_written(interfaces):
    wire, kind = wire_of(interfaces), interfaces.message("sensor_msgs/JointState")
    message = kind(name=["a"], position=[0.5])
    read = wire.decode(wire.encode(message), kind)
    assert (list(read.name), list(read.position)) == (["a"], [0.5])
    assert wire.content(wire.encode(message), read) == wire.encode(message)
    assert wire.message(kind)["type"] == "sensor_msgs/JointState"


def test_the_parts_of_a_service_are_its_classes(interfaces):
    wire, kind = wire_of(interfaces), interfaces.service("std_srvs/SetBool")
    request, response = wire.parts(kind)
    assert request(data=True).data
    assert wire.decode(wire.encode(response(success=True, message="on")), response).message == "on"
    assert wire.service("std_srvs/SetBool", kind)["type"] == "std_srvs/SetBool"


def test_only_messages_of_ros1_begin_with_a_number():
    content = bytes([2, 1, 0, 0, 9])
    one, two = Interfaces(), Interfaces2()
    assert wire_of(one).number(content, one.message("sensor_msgs/JointState")) == 258
    assert wire_of(one).number(content, one.message("std_msgs/String")) is None
    assert wire_of(two).number(content, two.message("sensor_msgs/JointState")) is None


def test_padding_tells_nothing():
    interfaces = Interfaces2()
    wire, kind = wire_of(interfaces), interfaces.message("sensor_msgs/JointState")
    body = bytearray(wire.encode(kind(name=["a"], position=[0.5])))
    at = body.index(b"a\0") + 2
    body[at] = 0xFF
    read = wire.decode(bytes(body), kind)
    assert bytes(body) != wire.encode(read)
    assert wire.content(bytes(body), read) == wire.encode(kind(name=["a"], position=[0.5]))
