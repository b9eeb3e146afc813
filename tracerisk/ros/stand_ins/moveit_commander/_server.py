"""The move_group server that every class of the library asks."""

from tracerisk.ros.graph.runtime import current
from tracerisk.ros.moveit.move_group import MoveGroupServer


def server() -> MoveGroupServer:
    """Return the server of the run.

    Raises:
        RuntimeError: no controller is being run.
    """
    return current().client(MoveGroupServer)
