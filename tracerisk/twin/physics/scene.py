"""A scene as data: what stands around the robot, what it can grasp, and where that belongs.

Coordinates are in the world frame [m, rad]; z points up.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tracerisk.common.geometry.shapes import Shape, read_shapes
from tracerisk.common.text.yaml_reader import YamlMap, read_large_yaml, read_yaml
from tracerisk.errors import RobotError, one_of

SHIPPED_SCENES = Path(__file__).parent / "scenes"
"""Where the files of the shipped scenes are."""

Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Fixture:
    """A body that never moves: a table, a rack."""

    name: str
    """The name, unique among the bodies of the scene."""
    xyz: Triple
    """The place of the origin in the world [m]."""
    rpy: Triple
    """Roll, pitch and yaw in the world [rad]."""
    shapes: tuple[Shape, ...]
    """The primitives, in the frame of the body."""
    meets_robot: bool = True
    """Whether robot and attached objects collide with it; free objects rest on it in any case."""


@dataclass(frozen=True, slots=True)
class GraspableObject:
    """A free body."""

    name: str
    """The name, unique among the bodies of the scene."""
    xyz: Triple
    """The place of the origin in the world when the run begins [m]."""
    rpy: Triple
    """Roll, pitch and yaw in the world when the run begins [rad]."""
    mass: float
    """The mass [kg]."""
    friction: float
    """The coefficient of sliding friction against fixtures; finger pads bring their own."""
    shapes: tuple[Shape, ...]
    """The primitives, in the frame of the body."""


@dataclass(frozen=True, slots=True)
class Goal:
    """A place where an object may end."""

    name: str
    """The name of the place, such as `rack_slot_1`."""
    xyz: Triple
    """The place of the object's origin in the world [m]."""


@dataclass(frozen=True, slots=True)
class Scene:
    """A scene with one robot."""

    name: str
    """The name by which a run chooses a shipped scene."""
    title: str
    """A short description for outputs."""
    robot_xyz: Triple
    """The place of the robot's base link in the world [m]."""
    robot_rpy: Triple
    """Roll, pitch and yaw of the robot's base link in the world [rad]."""
    fixtures: tuple[Fixture, ...]
    """The bodies that never move, racks among them."""
    objects: tuple[GraspableObject, ...]
    """The bodies that can be grasped."""
    goals: tuple[Goal, ...]
    """The places where objects may end."""
    file: str
    """The path of the scene file, for messages; of a shipped scene its file name."""


@dataclass(frozen=True, slots=True)
class _Rack:
    """A row of square slots open at the top."""

    name: str
    """The name of the rack."""
    first: Triple
    """The middle of slot 1 at its foot, in the world [m]."""
    pitch: float
    """The distance between the middles of two slots, along x [m]."""
    slots: int
    """The number of slots."""
    opening: float
    """The inner width of a slot [m]."""
    height: float
    """The height of the rack [m]."""
    floor: float
    """The thickness of its floor [m]."""
    wall: float
    """The thickness of its long walls [m]."""

    def bottom_of(self, slot: int) -> Triple:
        """Return the middle of a slot's floor; slots count from 1."""
        x, y, z = self.first
        return x + self.pitch * (slot - 1), y, z + self.floor

    def shapes(self) -> tuple[Shape, ...]:
        """Return floor, long walls and dividers, in the frame of the rack's first slot."""
        half_open, half_wall = self.opening / 2, self.wall / 2
        half_rib = (self.pitch - self.opening) / 2
        half_length = self.pitch * (self.slots - 1) / 2 + half_open + 2 * half_rib
        middle = self.pitch * (self.slots - 1) / 2
        half_up = (self.height - self.floor) / 2
        up = self.floor + half_up
        floor = Shape(
            "box",
            (half_length, half_open + 2 * half_wall, self.floor / 2),
            (middle, 0, self.floor / 2),
        )
        sides = [
            Shape("box", (half_length, half_wall, half_up), (middle, side, up))
            for side in (-half_open - half_wall, half_open + half_wall)
        ]
        ribs = [
            Shape("box", (half_rib, half_open, half_up), ((index - 0.5) * self.pitch, 0.0, up))
            for index in range(self.slots + 1)
        ]
        return floor, *sides, *ribs


@cache
def scene_names() -> tuple[str, ...]:
    """Return the names of the shipped scenes, sorted."""
    return tuple(sorted(path.stem for path in SHIPPED_SCENES.glob("*.yaml")))


def load_scene(name_or_path: str | Path) -> Scene:
    """Read a shipped scene by its name, or a scene file by its path.

    Raises RobotError with file and line when the file is malformed, or with the names of the
    shipped scenes when there is no such scene.
    """
    text = str(name_or_path)
    if text in scene_names():
        return _shipped(text)
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml"):
        return _scene(read_yaml(path, RobotError), text)
    raise RobotError(
        f"unknown scene '{text}'; {one_of(scene_names(), text)}; or give a scene file (.yaml)"
    )


@cache
def _shipped(name: str) -> Scene:
    path = SHIPPED_SCENES / f"{name}.yaml"
    return _scene(read_large_yaml(path, RobotError, shown=f"scenes/{path.name}"), path.name)


def _scene(top: YamlMap, file: str) -> Scene:
    top.forbid_unknown({"name", "title", "robot_base", "fixtures", "racks", "objects", "goals"})
    racks = {rack.name: rack for rack in map(_rack, top.maps("racks"))}
    fixtures = [_fixture(entry) for entry in top.maps("fixtures")]
    fixtures += [
        Fixture(rack.name, rack.first, (0.0, 0.0, 0.0), rack.shapes()) for rack in racks.values()
    ]
    objects = [thing for entry in top.maps("objects") for thing in _objects(entry, racks)]
    goals = [goal for entry in top.maps("goals") for goal in _goals(entry, racks)]
    names = [fixture.name for fixture in fixtures] + [thing.name for thing in objects]
    for name in names:
        if names.count(name) > 1:
            raise RobotError(
                f"'{name}' is defined twice; give each body its own name", top.location
            )
    base = top.section("robot_base")
    base.forbid_unknown({"xyz", "rpy"})
    return Scene(
        name=top.string("name"),
        title=top.string("title"),
        robot_xyz=base.triple("xyz"),
        robot_rpy=base.triple("rpy"),
        fixtures=tuple(fixtures),
        objects=tuple(objects),
        goals=tuple(goals),
        file=file,
    )


def _rack(entry: YamlMap) -> _Rack:
    entry.forbid_unknown(
        {"name", "first_slot", "pitch", "slots", "opening", "height", "floor", "wall"}
    )
    rack = _Rack(
        name=entry.string("name"),
        first=entry.triple("first_slot"),
        pitch=entry.number("pitch", minimum=0.001),
        slots=entry.integer("slots", minimum=1),
        opening=entry.number("opening", minimum=0.001),
        height=entry.number("height", minimum=0.002),
        floor=entry.number("floor", minimum=0.001),
        wall=entry.number("wall", minimum=0.001),
    )
    if rack.pitch <= rack.opening:
        entry.fail("pitch", f"{rack.pitch:g} leaves no rib between openings of {rack.opening:g}")
    if rack.height <= rack.floor:
        entry.fail("height", f"{rack.height:g} is not above the floor's {rack.floor:g}")
    return rack


def _fixture(entry: YamlMap) -> Fixture:
    entry.forbid_unknown({"name", "xyz", "rpy", "shapes", "meets_robot"})
    return Fixture(
        name=entry.string("name"),
        xyz=entry.triple("xyz"),
        rpy=entry.triple("rpy"),
        shapes=read_shapes(entry),
        meets_robot=entry.boolean("meets_robot", default=True),
    )


def _objects(entry: YamlMap, racks: dict[str, _Rack]) -> list[GraspableObject]:
    entry.forbid_unknown(
        {"name", "mass", "friction", "shapes", "xyz", "rpy", "stands_in", "origin_height"}
    )
    name, shapes = entry.string("name"), read_shapes(entry)
    mass = entry.number("mass", minimum=1e-6)
    friction = entry.number("friction", default=0.5, minimum=0.0)
    rpy = entry.triple("rpy")
    if "stands_in" not in entry:
        return [GraspableObject(name, entry.triple("xyz"), rpy, mass, friction, shapes)]
    return [
        GraspableObject(f"{name}_{slot}", place, rpy, mass, friction, shapes)
        for slot, place in _places(entry, "stands_in", racks)
    ]


def _goals(entry: YamlMap, racks: dict[str, _Rack]) -> list[Goal]:
    entry.forbid_unknown({"name", "xyz", "slots_of", "origin_height"})
    if "slots_of" not in entry:
        return [Goal(entry.string("name"), entry.triple("xyz"))]
    rack = entry.string("slots_of")
    return [Goal(f"{rack}_slot_{slot}", place) for slot, place in _places(entry, "slots_of", racks)]


def _places(entry: YamlMap, key: str, racks: dict[str, _Rack]) -> list[tuple[int, Triple]]:
    rack = racks[entry.choice(key, racks, "rack")]
    height = entry.number("origin_height", minimum=0.0)
    places = []
    for slot in range(1, rack.slots + 1):
        x, y, z = rack.bottom_of(slot)
        places.append((slot, (x, y, z + height)))
    return places
