"""The move_group server that every class of the library asks."""

from tracerisk.ros.move_group import MoveGroupServer
from tracerisk.ros.runtime import current


def server() -> MoveGroupServer:
    """Return the server of the run.

    Raises:
        RuntimeError: no controller is being run.
    """
    return current().client(MoveGroupServer)
