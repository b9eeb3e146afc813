"""Which addresses belong to a run, with and without a network of its own."""

import _socket
import errno
import socket

import pytest

from tests.forked import in_child
from tracerisk.common.sandbox import loopback
from tracerisk.common.sandbox.kernel import features
from tracerisk.common.sandbox.kernel.features import offers_own_network, support

pytestmark = pytest.mark.skipif(bool(support().missing), reason="needs Landlock and seccomp")


def told(*, own_network: bool) -> dict[str, bool]:
    """Return what a contained process takes for addresses of its run."""

    def contained() -> dict[str, bool]:
        loopback.has_own_network.cache_clear()
        has_left = own_network and features.leave_network()
        features.restrict(["/usr", "/etc/hosts"], [], [], own_network=has_left)
        sock, other = socket.socket(), socket.socket(type=socket.SOCK_DGRAM)
        server = other
        if has_left:
            server = socket.create_server(("127.0.0.1", 0))
            other.bind(("127.0.0.1", 0))
        at, unused = server.getsockname(), ("127.0.0.1", 9)
        return {
            "bound": loopback.is_of_run("socket.bind", sock, ("127.0.0.1", 0)),
            "served": loopback.is_of_run("socket.connect", sock, at),
            "by name": loopback.is_of_run("socket.connect", sock, ("localhost", at[1])),
            "received": loopback.is_of_run("socket.sendto", other, other.getsockname()),
            "unused": loopback.is_of_run("socket.connect", sock, unused),
            "of the system": loopback.is_of_run("socket.connect", sock, ("127.0.0.1", 22)),
            "elsewhere": loopback.is_of_run("socket.connect", sock, ("192.0.2.1", at[1])),
            "no address": loopback.is_of_run("socket.connect", sock, "/run/some/socket"),
        }

    return in_child(contained)


@pytest.mark.skipif(not offers_own_network(), reason="needs a network of its own")
def test_what_its_own_parts_listen_on_belongs_to_a_run():
    found = told(own_network=True)
    assert {name for name, is_so in found.items() if is_so} == {
        *("bound", "served", "by name", "received"),
    }


def test_no_address_belongs_to_a_run_without_a_network_of_its_own():
    assert not any(told(own_network=False).values())


@pytest.mark.parametrize(
    ("address", "text"),
    [(("127.0.0.1", 80), "127.0.0.1:80"), (b"/run/a", "/run/a"), (("::1", 8, 0, 0), "::1:8")],
)
def test_an_address_is_named(address, text):
    assert loopback.address_text(address) == text


@pytest.mark.skipif(not offers_own_network(), reason="needs a network of its own")
@pytest.mark.parametrize("missing", [_socket.AF_INET, _socket.AF_NETLINK])
def test_a_system_without_one_kind_of_sockets_offers_no_network(monkeypatch, missing):
    real = _socket.socket

    def made(family, *more):
        if family == missing:
            raise OSError(errno.EAFNOSUPPORT, "Address family not supported by protocol")
        return real(family, *more)

    monkeypatch.setattr(_socket, "socket", made)
    assert not offers_own_network()
