"""What calls of sockets do in virtual time: they wait for the other end, unless told not to."""

import socket
import threading
import time

import pytest

SECOND = 1_000_000_000
SIZE = 64  # that of MSG_DONTWAIT too
READERS = {
    "recv": lambda sock: sock.recv(SIZE),
    "recv_into": lambda sock: sock.recv_into(bytearray(SIZE), SIZE),
    "recvfrom": lambda sock: sock.recvfrom(SIZE),
    "recvfrom_into": lambda sock: sock.recvfrom_into(bytearray(SIZE), SIZE),
    "recvmsg": lambda sock: sock.recvmsg(SIZE, SIZE),
    "recvmsg_into": lambda sock: sock.recvmsg_into([bytearray(SIZE)], SIZE),
}


def beside(act):
    """Return a function that acts with an end of a pair while a thread sends to it after 1 s."""

    def main():
        one, other = socket.socketpair()
        one.settimeout(3)  # else a call that waits in real time waits forever
        with one, other:
            thread = threading.Thread(target=lambda: (time.sleep(1), other.send(b"x")))
            thread.start()
            result = act(one)
            thread.join()
            return result

    return main


@pytest.mark.parametrize("name", READERS)
def test_each_way_to_read_waits_for_the_other_end(run, scheduler, name):
    result = run(beside(READERS[name]))
    assert result in (1, b"x") or result[0] in (1, b"x")
    assert scheduler.now_ns == SECOND


@pytest.mark.parametrize(
    "read",
    [
        lambda sock: sock.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT),
        lambda sock: sock.recv_into(bytearray(1), 1, socket.MSG_DONTWAIT),
        lambda sock: sock.recv_into(bytearray(1), flags=socket.MSG_DONTWAIT),
        lambda sock: sock.recvmsg(1, 0, socket.MSG_DONTWAIT),
    ],
)
def test_a_call_that_is_not_to_wait_does_not(run, read):
    def act(sock):
        sock.settimeout(None)
        began = time.monotonic()
        with pytest.raises(BlockingIOError):
            read(sock)
        return time.monotonic() - began

    assert run(beside(act)) < 0.1
