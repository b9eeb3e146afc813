"""The move_group server that every class of the library asks."""

from tracerisk.errors import one_of
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.moveit.move_group import MoveGroupServer


def server() -> MoveGroupServer:
    """Return the server of the run.

    Raises:
        RuntimeError: no controller is being run.
    """
    return current().client(MoveGroupServer)


def report_unknown(name: str, what: str) -> str:
    """Report that an object cannot be moved or attached, for the scene lacks it; return so."""
    kind = "attach_failure" if what == "attached" else "planning_scene"
    text = f"object '{name}' cannot be {what}: the planning scene has no such object"
    known = one_of(server().scene.world, name)
    server().execution.report(kind, f"{text}; {known}", object_name=name)
    return text
