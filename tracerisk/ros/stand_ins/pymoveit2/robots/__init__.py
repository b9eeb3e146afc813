"""Names of joints, links and groups of robots, as pymoveit2 has them.

Forks of the library have more robots. A module that it lacks is made of the twin's robot, and the
run says so.
"""

from types import ModuleType as _ModuleType

from . import crane_x7, kinova, lbr, panda, phantomx_pincher, ur

__all__ = ["crane_x7", "kinova", "lbr", "panda", "phantomx_pincher", "ur"]


def __getattr__(name: str) -> _ModuleType:
    if name.startswith("_"):
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    from tracerisk.ros.controller.needs import asking_place
    from tracerisk.ros.graph.runtime import current

    from ._of_twin import module_of

    robot = current().twin.robot
    current().recorder.finding(
        "unprovided",
        f"pymoveit2.robots has no '{name}', which a fork of the library may have: the names of "
        f"its joints, links and groups are those of {robot.name}; put the fork's sources into the "
        "workspace",
        asking_place(),
    )
    module = globals()[name] = module_of(robot, f"{__name__}.{name}")
    return module
