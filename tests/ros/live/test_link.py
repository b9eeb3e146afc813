"""Frames between the processes of a live run."""

import socket
import struct

import pytest

from tracerisk.ros.live.link import Link


@pytest.fixture
def ends():
    one, two = socket.socketpair()
    links = Link(one), Link(two)
    yield links
    for each in links:
        each.close()


def test_a_frame_arrives_whole_in_whatever_pieces(ends):
    sender, receiver = ends
    body = bytes(range(256)) * 200
    sender.send({"is": "message", "topic": "/a"}, body)
    sender.send({"is": "over"})
    assert receiver.receive() == ({"is": "message", "topic": "/a"}, body)
    assert receiver.waiting() == [({"is": "over"}, b"")]
    assert receiver.waiting() == []


def test_an_end_that_is_gone_is_known(ends):
    sender, receiver = ends
    sender.send({"is": "last"})
    sender.close()
    assert receiver.waiting() == [({"is": "last"}, b"")]
    assert receiver.is_closed
    assert receiver.receive() is None


def test_a_length_that_nobody_sends_is_refused():
    one, two = socket.socketpair()
    with one:
        receiver = Link(two)
        one.sendall(struct.pack("<II", 1 << 31, 0))
        with pytest.raises(ValueError, match="a frame of 2147483648 bytes"):
            receiver.receive()
        receiver.close()
