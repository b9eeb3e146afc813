"""The order in which drivers publish the states of joints: seldom that of the arm.

ROS 1: ros-controls/ros_controllers joint_state_controller/src/joint_state_controller.cpp lists the
joints of its parameter `joints`, else those of the hardware, whose names a `std::map` keeps.
ROS 2: ros-controls/ros2_controllers joint_state_broadcaster/src/joint_state_broadcaster.cpp. Jazzy
lists the joints of the URDF, which a `std::map` keeps; Humble those of a `std::unordered_map`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from typing import TYPE_CHECKING

from tracerisk.ros.graph.declared_controllers import DeclaredControllers

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

ORDER = "joint-states-order"

_PUBLISHERS = ("joint_state_controller", "joint_state_broadcaster")
_OWN_ORDER = (
    *("baxter", "fetch", "sawyer", "px", "rx", "vx", "wx", "mycobot", "open_manipulator"),
    *("panda", "fr3"),
)
"""Robots, by how their names begin, whose drivers publish in an order of their own, not by
ros_control; those of Franka by joint_state_publisher, in the order of the URDF:
frankaemika/franka_ros franka_control/launch/franka_control.launch."""
_UR_PARTS = (
    *("speed_scaling", "tcp_fts_sensor", "gpio", "system_interface", "tcp_pose"),
    *("get_robot_software_version", "tool_contact"),
)
"""What a UR driver has states of after its joints: UniversalRobots/Universal_Robots_ROS2_Driver
ur_robot_driver/src/hardware_interface.cpp, `export_state_interfaces` of Humble, up to its release
2.10, which added one more."""
_MASK = (1 << 64) - 1
_BUCKETS = (13, 29, 59, 127, 257, 541)
"""The numbers of buckets that an unordered map of libstdc++ grows by."""


class StateOrder:
    """The order of the states of a run's joints: `runtime.client(StateOrder)`."""

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._orders: dict[tuple[str, ...], tuple[int, ...]] = {}

    def places(self, names: Sequence[str]) -> tuple[int, ...]:
        """Return the places of joints, in the robot's order, in that of its driver.

        Joints that it publishes no states of are left out.
        """
        known = tuple(names)
        if known not in self._orders:
            robot = getattr(self._runtime.twin, "robot", None)
            unpublished = frozenset() if robot is None else robot.unpublished
            ordered = self._ordered(tuple(name for name in known if name not in unpublished))
            self._orders[known] = tuple(known.index(name) for name in ordered)
        return self._orders[known]

    def _ordered(self, names: tuple[str, ...]) -> Sequence[str]:
        rule = self._runtime.distro.value(ORDER)
        robot = getattr(self._runtime.twin, "robot", None)
        robot_name = "" if robot is None else robot.name
        declared = self._runtime.client(DeclaredControllers).all
        listed = next(
            (declared[publisher].joints for publisher in _PUBLISHERS if publisher in declared), ()
        )
        asked = tuple(name for name in listed if name in names)
        rest = tuple(name for name in names if name not in asked)
        if rule == "of an unordered map":
            parts = _UR_PARTS if robot_name.startswith("ur") else ()
            texts = unordered([*reversed(parts), *reversed((*asked, *rest))])
            return [name for name in texts if name in names]
        if asked:
            return (*asked, *rest)
        return names if robot_name.startswith(_OWN_ORDER) else sorted(names)


def unordered(keys: Iterable[str]) -> list[str]:
    """Return keys as `std::unordered_map` of libstdc++ lists them, which were put in one by one.

    Buckets are parts of one list; a key comes before those that are in its bucket already, and
    the first of a bucket before all. GCC libstdc++-v3/include/bits/hashtable.h.
    """
    listed: list[str] = []
    sizes = iter(_BUCKETS)
    buckets = 1

    def put(into: list[str], key: str) -> None:
        own = _hash(key) % buckets
        into.insert(next((i for i, k in enumerate(into) if _hash(k) % buckets == own), 0), key)

    for key in dict.fromkeys(keys):
        if len(listed) + 1 > (0 if buckets == 1 else buckets):
            buckets = next(sizes)
            before, listed = listed, []
            for other in before:
                put(listed, other)
        put(listed, key)
    return listed


@cache
def _hash(text: str) -> int:
    """Return the hash of libstdc++ for strings: MurmurHash64A, by Austin Appleby."""
    factor, data = 0xC6A4A7935BD1E995, text.encode()
    number = 0xC70F6907 ^ (len(data) * factor & _MASK)
    whole = len(data) & ~7
    for at in range(0, whole, 8):
        word = int.from_bytes(data[at : at + 8], "little") * factor & _MASK
        number = (number ^ ((word ^ word >> 47) * factor & _MASK)) * factor & _MASK
    if whole < len(data):
        number = (number ^ int.from_bytes(data[whole:], "little")) * factor & _MASK
    number = (number ^ number >> 47) * factor & _MASK
    return number ^ number >> 47
