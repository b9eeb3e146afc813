"""What two processes cannot share keeps one of them from being forked."""

import os
import socket

import pytest

from tracerisk.common.sandbox import forking
from tracerisk.common.sandbox.forking import NotForkableError


def test_a_pipe_that_the_controller_has_opened_is_refused():
    for end in (pair := os.pipe()):
        with pytest.raises(NotForkableError, match="has an open pipe or event queue,"):
            forking._reopened(end, {}, frozenset())
        assert forking._reopened(end, {}, frozenset(pair)) is None
    for end in pair:
        os.close(end)


def test_a_socket_that_the_controller_has_opened_is_refused():
    with socket.socket() as opened, pytest.raises(NotForkableError, match="has an open socket"):
        forking._reopened(opened.fileno(), {}, frozenset())


def test_a_file_to_write_into_is_refused_where_it_has_no_copy(tmp_path):
    with (tmp_path / "log").open("w") as file:
        with pytest.raises(NotForkableError, match="log open for writing"):
            forking._reopened(file.fileno(), {}, frozenset())
        (tmp_path / "copies").mkdir()
        (tmp_path / "copies" / "log").touch()
        copies = {str(tmp_path): str(tmp_path / "copies")}
        fresh = forking._reopened(file.fileno(), copies, frozenset())
        assert fresh is not None
        assert os.path.samestat(os.fstat(fresh), (tmp_path / "copies" / "log").stat())
        os.close(fresh)


def test_a_file_that_is_held_and_not_read_may_be_shared(tmp_path):
    (tmp_path / "held.py").touch()
    held = os.open(tmp_path / "held.py", os.O_PATH)
    assert forking._reopened(held, {}, frozenset()) is None
    os.close(held)
