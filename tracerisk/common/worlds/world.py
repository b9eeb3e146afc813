"""The worlds that a real cell may be: how messages, names, joints and plans may come there.

A controller that is right brings about the same in each of them. `WORLDS` is the table that the
code reads; docs/worlds.md explains each.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeVar

from tracerisk.common.text.digests import sha256
from tracerisk.errors import InputError, one_of

Range = tuple[float, float]
"""The least and the greatest value."""
JointOrder = Literal["robot", "alphabetical", "reversed", "rotated"]
"""How joint states list the joints; `robot`: as its driver does."""
Item = TypeVar("Item")

_NEVER: Range = (0.0, 0.0)
_DIGITS = 13  # of a digest, in base 16: as many as a number of 64 bits keeps exactly


@dataclass(frozen=True, slots=True)
class World:
    """How the cell around a controller behaves where ROS and the drivers leave it open."""

    name: str
    """The name by which `--worlds` chooses it."""
    description: str
    """What is different there, as a sentence of a table."""
    source: str
    """Where that is documented, or the code that does it: `owner/repo path`, or an address."""
    latency_s: Range = _NEVER
    """How long a message, request, response or goal is on its way between controller and cell,
    [s]."""
    reverses_topics: bool = False
    """Whether what is sent at the same time on several topics arrives in the reverse order."""
    discovery_s: Range = _NEVER
    """How long it takes until an endpoint of the controller and one of the cell are connected,
    [s]."""
    planning_s: Range = _NEVER
    """How long a plan takes, [s]."""
    joint_order: JointOrder = "robot"
    """The order in which joint states list the joints."""
    gripper: float | None = None
    """How far grippers are open when the run begins: 0 closed, 1 wide open; None: as the robot
    says."""
    takes_other_solution: bool = False
    """Whether a pose goal is reached in another posture than the nearest, where there is one."""
    start_off_rad: float = 0.0
    """How far each joint of the arm may be from its place when the run begins, [rad or m]."""

    @property
    def has_discovery(self) -> bool:
        """Whether ends need more time to connect than the distribution of ROS says."""
        return self.discovery_s[1] > 0.0

    @property
    def decides_start(self) -> bool:
        """Whether the robot begins elsewhere."""
        return self.gripper is not None or self.start_off_rad > 0.0

    def drawn(self, within: Range, *key: object) -> float:
        """Return a value of a range, always the same for the same key."""
        low, high = within
        if high <= 0.0:
            return 0.0
        text = "\n".join(map(str, (self.name, *key)))
        digits = sha256(text.encode())[:_DIGITS]
        return low + (high - low) * int(digits, 16) / float(16**_DIGITS)

    def drawn_ns(self, within: Range, *key: object) -> int:
        """Return a time of a range, as `drawn`, in [ns]."""
        return round(self.drawn(within, *key) * 1e9)

    def ordered(self, joints: Sequence[str]) -> list[str]:
        """Return the names of joints in the order in which joint states list them."""
        match self.joint_order:
            case "alphabetical":
                return sorted(joints)
            case "reversed":
                return [*reversed(joints)]
            case "rotated":
                return [*joints[-1:], *joints[:-1]]
        return [*joints]


NOMINAL = World("nominal", "the run itself", "")
"""The world of a plain run."""

WORLDS = (
    World(
        "latency",
        "messages, calls and goals are delayed by 5 to 40 ms",
        "https://github.com/moveit/moveit_ros/issues/442",
        latency_s=(0.005, 0.040),
    ),
    World(
        "order",
        "of messages sent at the same time on several topics, the last arrives first",
        "https://github.com/introlab/rtabmap_ros/issues/1205",
        latency_s=(0.002, 0.040),
        reverses_topics=True,
    ),
    World(
        "discovery",
        "publishers, subscribers, services and actions take 0.2 to 1 s to connect",
        "https://github.com/ros2/ros2/issues/698",
        discovery_s=(0.2, 1.0),
    ),
    World(
        "planning",
        "each plan takes 0.3 to 2 s",
        "https://github.com/AndrejOrsula/pymoveit2/issues/73",
        planning_s=(0.3, 2.0),
    ),
    World(
        "joints-alphabetical",
        "joint states list the joints in order of their names",
        "https://github.com/UniversalRobots/Universal_Robots_ROS_Driver/issues/619",
        joint_order="alphabetical",
    ),
    World(
        "joints-reversed",
        "joint states list the joints in reverse order",
        "https://github.com/kroshu/kuka_drivers/issues/254",
        joint_order="reversed",
    ),
    World(
        "joints-rotated",
        "joint states list the last joint first",
        "https://github.com/kroshu/kuka_drivers/issues/254",
        joint_order="rotated",
    ),
    World(
        "gripper-open",
        "grippers are open when the run begins",
        "https://github.com/pharmbio/robotlab/issues/2",
        gripper=1.0,
    ),
    World(
        "gripper-closed",
        "grippers are closed when the run begins",
        "https://github.com/pharmbio/robotlab/issues/2",
        gripper=0.0,
    ),
    World(
        "gripper-half",
        "grippers are half open when the run begins",
        "https://github.com/pharmbio/robotlab/issues/2",
        gripper=0.5,
    ),
    World(
        "other-solution",
        "pose goals are reached in another arm configuration, if there is one",
        "https://github.com/nasa/ow_simulator/issues/406",
        takes_other_solution=True,
    ),
    World(
        "start",
        "each joint starts up to 4 mrad off",
        "https://github.com/Kinovarobotics/ros_kortex/issues/54",
        start_off_rad=0.004,
    ),
)
"""All worlds, in the order in which they are run and reported."""
_BY_NAME = {world.name: world for world in (NOMINAL, *WORLDS)}
ALL = "all"
"""The name that stands for all of them."""


def world_named(name: str) -> World:
    """Return the world of a name; raise InputError listing those there are."""
    if name not in _BY_NAME:
        known = [world.name for world in WORLDS]
        raise InputError(f"unknown world '{name}'; {one_of(known, name)}")
    return _BY_NAME[name]


def group_names() -> list[str]:
    """Return the names that each stand for all worlds whose names begin so."""
    heads = Counter(world.name.split("-")[0] for world in WORLDS)
    return [head for head, number in heads.items() if number > 1]


def worlds_named(names: str) -> tuple[World, ...]:
    """Return the worlds of names between commas, in the order of the table; `all` for each.

    `gripper` and `joints` stand for all whose names begin so.
    Raises InputError for a name that there is not, and for none.
    """
    asked = [name.strip() for name in names.split(",") if name.strip()]
    texts = set()
    groups = group_names()
    for name in asked:
        if name == ALL:
            texts |= {world.name for world in WORLDS}
        elif name in groups:
            texts |= {world.name for world in WORLDS if world.name.startswith(f"{name}-")}
        elif name in _BY_NAME and name != NOMINAL.name:
            texts.add(name)
        else:
            known = [ALL, *groups, *(world.name for world in WORLDS)]
            raise InputError(f"unknown world '{name}'; {one_of(known, name)}")
    if not texts:
        raise InputError(f"names no world; {one_of([ALL, *(item.name for item in WORLDS)])}")
    return tuple(world for world in WORLDS if world.name in texts)
